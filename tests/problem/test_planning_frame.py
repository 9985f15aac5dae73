"""The frame that a scene is planned in: where it lies, which way it points, and its units."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.problem.planning_frame import GRID, TYPICAL_RADIUS, TYPICAL_SPEED, PlanningFrame, share
from stplan.scene import parse_scene
from stplan.world.free_space import FreeSpace, build_free_space

TRIPS = """
stplan: 1
horizon: 22
agents:
  - {id: a, start: [2, 1], goal: [2, 5], start_time: 2, radius: 0.6, mass: 4}
  - {id: b, start: [5, 1], goal: [5, 11], start_time: 12, radius: 0.6, mass: 9}
  - {id: c, start: [0, 0], goal: [6, 8], start_time: 2, radius: 0.2, mass: 6}
"""


def frame_of(text: str) -> PlanningFrame:
    scene = parse_scene(text)
    return PlanningFrame.of_scene(scene, build_free_space(scene))


def test_it_begins_where_the_first_of_the_longest_trips_does_and_runs_along_it() -> None:
    frame = frame_of(TRIPS)
    assert frame.origin == (5.0, 1.0)
    assert frame.start == 2.0
    assert (frame.cosine, frame.sine) == (0.0, 1.0)
    there = frame.local_points(np.array([[5.0, 1.0], [5.0, 11.0]]))
    assert there == pytest.approx(np.array([[0.0, 0.0], [10.0 / frame.length, 0.0]]))


def test_radii_and_speeds_are_ordinary_in_it() -> None:
    frame = frame_of(TRIPS)
    assert 0.6 / frame.length == pytest.approx(TYPICAL_RADIUS)
    # 4 m in 20 s, 10 m in 10 s, 10 m in 20 s.
    assert 0.5 / frame.speed == pytest.approx(TYPICAL_SPEED)
    assert frame.mass == pytest.approx(6.0)
    assert frame.cost == pytest.approx(frame.mass * frame.length**2 / frame.time)
    assert frame.acceleration == pytest.approx(frame.length / frame.time**2)


def test_who_stands_still_has_a_frame_too() -> None:
    frame = frame_of("stplan: 1\nhorizon: 8\nagents: [{id: a, start: [3, 4], goal: [3, 4]}]")
    assert frame.origin == (3.0, 4.0)
    assert frame.time == pytest.approx(8.0)


def test_a_horizon_that_nobody_has_a_use_for_changes_nothing() -> None:
    hurried = """
stplan: 1
horizon: HORIZON
defaults: {max_speed: 1, max_acceleration: 0.8, preferred_time: 0.1, weights: {arrival: 10}}
agents:
  - {id: a, start: [1, 2], goal: [19, 2]}
  - {id: b, start: [19, 8], goal: [1, 8]}
"""
    assert frame_of(hurried.replace("HORIZON", "60")) == frame_of(hurried.replace("HORIZON", "240"))


@pytest.mark.parametrize(
    ("ring", "turned"),
    [
        # Along the walls, although the trip is not; of two directions the one nearer to the trip.
        ("[[-1, -1], [9, -1], [9, 9], [-1, 9]]", 0.0),
        ("[[0, -2], [11, 9], [5, 15], [-6, 4]]", 45.0),
        # A wall in pieces counts as one.
        ("[[-1, -1], [2, -1], [4, -1], [9, -1], [9, 9], [3, 12], [-1, 9]]", 0.0),
    ],
)
def test_it_lies_along_most_of_the_walls(ring: str, turned: float) -> None:
    frame = frame_of(
        f"stplan: 1\nhorizon: 9\nmap: {{polygon: {ring}}}\n"
        "agents: [{id: a, start: [1, 1], goal: [5, 4]}]"
    )
    assert np.degrees(np.arctan2(frame.sine, frame.cosine)) == pytest.approx(turned, abs=1e-9)


def test_points_come_back_and_decimals_stay_what_they_are_however_far() -> None:
    places = np.array([[0.3, 1.7], [4.1, -2.9], [12.6, 0.05]])
    near = PlanningFrame(origin=(0.3, 1.7), cosine=0.6, sine=0.8, length=1.5)
    for shift in (5e5, 9.9e6, 1e8):
        moved = places + shift
        far = PlanningFrame(origin=tuple(moved[0].tolist()), cosine=0.6, sine=0.8, length=1.5)
        # To the last bit, although each coordinate has lost up to eight digits.
        assert np.array_equal(far.local_points(moved), near.local_points(places))
        assert far.points(far.local_points(moved)) == pytest.approx(moved, rel=1e-15)
    local = near.local_points(places)
    assert np.array_equal(local, np.round(local / GRID) * GRID)


def test_shares_keep_their_digits_whatever_their_size() -> None:
    for size in (1e-12, 1.0, 3e7):
        assert share(0.3 * size, size) == share(0.3, 1.0)
    assert share(0.0, 2.0) == 0.0
    assert share(np.inf, 2.0) == np.inf


def test_corners_that_only_rounding_makes_are_left_out() -> None:
    box = shapely.box(0, 0, 8, 6)
    cut = shapely.difference(box, shapely.box(3, 0, 4, 2))
    turn = PlanningFrame(cosine=np.cos(0.3), sine=np.sin(0.3))
    again = PlanningFrame(cosine=np.cos(0.3), sine=-np.sin(0.3))
    space = FreeSpace.from_polygon(cut)
    turned = FreeSpace.from_polygon(
        shapely.transform(shapely.segmentize(cut, 1.0), turn.local_points)
    )
    assert len(turned.boundary_vertices) > len(space.boundary_vertices)
    back = again.local_space(turned)
    assert back.boundary_vertices == pytest.approx(space.boundary_vertices, abs=1e-11)
    assert back.area.area == pytest.approx(space.area.area)
