"""The numbers that pictures show."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from stplan.analysis.crowd import Crowd
from stplan.analysis.paths import positions, segment_speeds
from stplan.analysis.tightness import pair_spots, wall_spots
from stplan.analysis.waiting import waits
from stplan.problem.planning_problem import prepare
from stplan.scene import load_scene
from stplan.viewing.clearances import pair_clearance, smallest_clearance, touching_point
from stplan.viewing.palette import agent_colours, hex_colours
from stplan.viewing.rod_meshes import rod_curve, rod_mesh
from stplan.viewing.run_view import open_run
from stplan.viewing.ticks import nice_step
from tests.viewing.runs import CURVES, hall_run


@pytest.fixture
def view(tmp_path):
    return open_run(hall_run(tmp_path))


def test_positions_and_presence(view):
    places = positions(view.lines, view.leaves, np.array([0.5, 4.0, 9.0, 9.5]))
    assert places[0, 1].tolist() == [0.0, 0.0]
    assert places[0, 2].tolist() == [4.0, 0.0]  # Stays on its goal.
    assert np.isnan(places[2, 0]).all()  # Not there yet.
    assert np.isnan(places[2, 3]).all()  # Vanished.


def test_speeds():
    np.testing.assert_allclose(segment_speeds(CURVES[1]), [1.0, 0.1 / 3.5, 1.2])


def test_nice_steps():
    assert [nice_step(span, 9) for span in (9.0, 10.0, 40.0, 0.3)] == [1.0, 2.0, 5.0, 0.05]


def test_tight_moments_are_those_that_sampling_finds(view):
    times = np.linspace(0.0, 9.0, 20001)
    moments = pair_spots(view.crowd)
    assert len(moments) == 3
    assert [m.clearance for m in moments] == sorted(m.clearance for m in moments)
    for moment in moments:
        who = [view.rows[name] for name in moment.who]
        sampled = pair_clearance(view, *who, times)
        assert np.nanmin(sampled) == pytest.approx(moment.clearance, abs=1e-3)
        assert moment.clearance <= np.nanmin(sampled) + 1e-12
        assert pair_clearance(view, *who, np.array([moment.time]))[0] == (
            pytest.approx(moment.clearance, abs=1e-9)
        )
    between, to_walls = smallest_clearance(view, times)
    assert between.min() == pytest.approx(moments[0].clearance, abs=1e-3)
    walls = wall_spots(view.crowd)
    assert to_walls.min() == pytest.approx(walls[0].clearance, abs=1e-3)
    # ben stands 0.5 m below the obstacle; its start is as far from the lower wall.
    ben = next(moment for moment in walls if moment.who == ("ben",))
    assert ben.clearance == pytest.approx(0.1)


def test_a_tight_spot_is_marked_between_the_rims(view):
    spot = next(spot for spot in pair_spots(view.crowd) if spot.who == ("ann", "ben"))
    places = positions(view.lines, view.leaves, np.array([spot.time]))[:2, 0]
    gaps = np.linalg.norm(places - touching_point(view, spot), axis=1) / view.radii[:2]
    assert gaps[0] == pytest.approx(gaps[1])
    # Both agree on the tightest moment, of which the spot says where the middle is.
    assert spot.place == pytest.approx(places.mean(axis=0))


def test_who_waits_for_whom(view):
    (wait,) = waits(view.crowd)
    assert (wait.agent, wait.begin, wait.end) == ("ben", 1.5, 5.0)
    assert wait.meeting is not None
    assert wait.meeting.agent == "ann"


def test_pictures_and_explanations_know_the_same_waits(view, tmp_path):
    problem = prepare(load_scene(tmp_path / "scene.yaml"))
    assert waits(view.crowd) == waits(Crowd.of_problem(problem, view.lines))


def test_who_waits_where_the_scene_is_lost(view, tmp_path):
    (tmp_path / "scene.yaml").unlink()
    assert waits(open_run(tmp_path / "hall").crowd) == waits(view.crowd)


def test_colours_of_neighbours_are_far_apart():
    colours = agent_colours(200)
    assert colours.min() >= 0.0
    assert colours.max() <= 1.0
    assert len(set(hex_colours(60))) == 60
    for window in range(0, 190, 3):
        few = colours[window : window + 6]
        gap = np.linalg.norm(few[:, None] - few[None, :], axis=2)[np.triu_indices(6, 1)]
        assert gap.min() > 0.12
    # Readable on white and on near black.
    luminance = colours @ [0.2126, 0.7152, 0.0722]
    assert luminance.min() > 0.15
    assert luminance.max() < 0.85


def test_a_rod_is_closed_and_as_large_as_what_the_disc_sweeps(view):
    curve = rod_curve(view.lines.curve(1), 9.0)
    assert curve[-1].tolist() == [0.0, 1.5, 9.0]
    vertices, triangles = rod_mesh(curve, 0.4, 64)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    assert mesh.is_watertight
    area = 0.5 * 64 * np.sin(2 * np.pi / 64) * 0.4**2
    # Outward faces: a positive volume. Level discs: shearing does not change it.
    assert mesh.volume == pytest.approx(area * 9.0)
    np.testing.assert_allclose(mesh.bounds, [[-0.4, -2.9, 0.0], [0.4, 1.9, 9.0]])
