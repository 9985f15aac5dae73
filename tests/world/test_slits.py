"""Walls without thickness: exact clearance on both sides, and everything made of the area sees them."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shapely

from stplan.certify.certificate import certify
from stplan.planner import plan
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.world import FreeSpace, build_free_space, cut_off_agents, eroded, widest_passage
from tests.world.scenes import scene


def free(*lines: str, base: str = "rectangle: [0, 0, 10, 10]") -> FreeSpace:
    """The free space of a square room with these lines."""
    walls = ", ".join(f"{{line: {line}}}" for line in lines)
    return build_free_space(scene(f"{{{base}, obstacles: [{walls}]}}"))


def test_clearance_is_the_exact_distance_on_both_sides() -> None:
    lines = ["[[2, 3], [5, 3], [6, 7]]", "[[8, 1], [8, 9]]", "[[1, 5], [2, 6], [1, 7], [1, 5]]"]
    space = free(*lines)
    shapes = [shapely.LineString(np.array(json.loads(line))) for line in lines]
    shapes.append(shapely.box(0, 0, 10, 10).exterior)
    points = np.random.default_rng(1).uniform(0, 10, (500, 2))
    true = np.min([shapely.distance(shapely.points(points), shape) for shape in shapes], axis=0)
    assert space.clearance(points) == pytest.approx(true, abs=1e-14)
    assert space.contains(points).all()
    assert not space.contains(np.array([[3.0, 3.0], [8.0, 5.0]])).any()
    starts, ends = points[:250], points[250:]
    paths = shapely.linestrings(np.stack([starts, ends], axis=1))
    blocked = np.any([shapely.intersects(paths, shape) for shape in shapes], axis=0)
    assert ((space.segment_clearance(starts, ends) <= 0) == blocked).all()
    assert 20 < blocked.sum() < 240


def test_every_corner_begins_an_edge() -> None:
    space = free("[[2, 3], [5, 3], [6, 7]]", "[[8, 1], [8, 9]]", "[[1, 5], [2, 6], [1, 7], [1, 5]]")
    begins = set(space.boundary_edges[:, 0].tolist())
    corners = {(2, 3), (5, 3), (6, 7), (8, 1), (8, 9), (1, 5), (2, 6), (1, 7), (0, 0), (10, 10)}
    assert corners <= {tuple(space.boundary_vertices[k].tolist()) for k in begins}
    assert np.hypot(*(space.boundary_segments[:, 2:] - space.boundary_segments[:, :2]).T).all()


def test_lines_outside_and_along_walls_add_nothing() -> None:
    plain = free("[[20, 1], [30, 2]]", "[[0, 1], [0, 5]]", "[[10, 2], [12, 2]]")
    assert plain.slits == ()
    assert plain.polygon.equals(shapely.box(0, 0, 10, 10))
    (slit,) = free("[[5, 5], [15, 5]]").slits
    assert slit.tolist() == [[5, 5], [10, 5]]


@pytest.mark.parametrize("shift", [0.0, 5e5, -8e6])
def test_erosion_and_parts_see_them(shift: float) -> None:
    base = f"rectangle: [{shift}, {shift}, {shift + 10}, {shift + 10}]"
    across = free(f"[[{shift}, {shift + 4}], [{shift + 10}, {shift + 4}]]", base=base)
    assert len(shapely.get_parts(across.polygon)) == 2
    assert across.area.area == pytest.approx(100)
    assert len(shapely.get_parts(eroded(across.polygon, 1.0))) == 2
    stops = [np.array([[1.0, 1.0], [9.0, 9.0]]) + shift]
    assert cut_off_agents(across, stops, np.array([0.1])) == [0]
    assert widest_passage(across, stops[0], 1.0) == 0.0
    gap = free(f"[[{shift}, {shift + 4}], [{shift + 9}, {shift + 4}]]", base=base)
    assert cut_off_agents(gap, stops * 2, np.array([0.499, 0.501])) == [1]
    assert widest_passage(gap, stops[0], 1.0) == pytest.approx(0.5, rel=2e-3)


@pytest.mark.parametrize("seed", range(4))
def test_opening_many_at_once_is_as_opening_each(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middles, steps = rng.uniform(-1, 11, (60, 1, 2)), rng.uniform(-1, 1, (60, 1, 2))
    crossing = list(np.hstack([middles - steps, middles + steps]))
    # Far apart, one of them around another, and one that parts the floor.
    x, y = np.divmod(np.arange(9), 3)
    short = [np.array([[a, b], [a + 0.2, b + 0.1]]) for a, b in zip(x + 14.0, y, strict=True)]
    ring = np.array([[14.6, 0.6], [15.5, 0.6], [15.5, 1.4], [14.6, 0.6]])
    across = np.array([[13.0, 5.0], [18.0, 5.0]])
    floor = shapely.MultiPolygon([shapely.box(0, 0, 10, 10), shapely.box(13, -1, 18, 9)])
    for slits in ([*short, *crossing[:20], ring], [*crossing, across], short):
        space = FreeSpace.from_polygon(floor, None, slits)
        lines = [shapely.LineString(line) for line in slits]
        hairs = shapely.buffer(lines, 9e-9, cap_style="square", join_style="mitre")
        each = shapely.difference(floor, shapely.union_all(hairs))
        assert space.polygon.is_valid
        assert len(shapely.get_parts(space.polygon)) == len(shapely.get_parts(each))
        assert shapely.symmetric_difference(space.polygon, each).area < 1e-11


def test_a_part_of_the_free_space_keeps_them() -> None:
    part = free("[[2, 3], [8, 3]]").within(shapely.box(4, 0, 10, 6))
    assert part.area.area == pytest.approx(36)
    assert part.clearance(np.array([[7.0, 3.5]]))[0] == 0.5
    assert part.clearance(np.array([[4.5, 5.0]]))[0] == 0.5


def test_thickness_is_half_to_either_side() -> None:
    walls = "{line: [[2, 3], [8, 3], [8, 6]], thickness: 0.5}"
    space = build_free_space(scene(f"{{rectangle: [0, 0, 10, 10], obstacles: [{walls}]}}"))
    assert space.slits == ()
    true = 100 - (6 * 0.5 + 3 * 0.5 + 0.25 * 0.25 - 0.25 * 0.25)
    assert space.polygon.area == pytest.approx(true)
    assert space.clearance(np.array([[5.0, 3.5], [1.5, 3.0], [8.5, 2.5]])) == pytest.approx(
        [0.25, 0.5, np.hypot(0.25, 0.25)]
    )
    ring = "{line: [[2, 2], [6, 2], [6, 6], [2, 6], [2, 2]], thickness: 1}"
    closed = build_free_space(scene(f"{{rectangle: [0, 0, 10, 10], obstacles: [{ring}]}}"))
    assert sorted(part.area for part in shapely.get_parts(closed.polygon)) == [9, 75]


ROOM = """\
stplan: 1
horizon: 40
map:
  rectangle: [0, 0, 10, 10]
  obstacles:
    - {line: [[0, 5], [6, 5]]}
    - {line: [[7, 5], [10, 5]]}
    - {line: [[3, 7], [3, 9], [5, 9], [5, 7]]}
seeding: {method: METHOD}
agents:
  - {id: a, start: [2, 2], goal: [4, 8], radius: 0.25}
  - {id: b, start: [8, 8], goal: [1, 1], radius: 0.2}
  - {id: c, start: [8, 3], goal: [1, 9], radius: 0.3}
"""
WALLS = ([[0, 5], [6, 5]], [[7, 5], [10, 5]], [[3, 7], [3, 9], [5, 9], [5, 7]])


@pytest.mark.parametrize("method", ["auto", "relaxation", "search", "dijkstra"])
@pytest.mark.parametrize("model", ["contacts", "smooth-minimum"])
def test_plans_keep_every_radius_from_them(method: str, model: str) -> None:
    room = parse_scene(
        ROOM.replace("METHOD", method), overrides=[f"solver.clearance_model={model}"]
    )
    planned = plan(room)
    assert planned.certificate.holds
    walls = [shapely.LineString(wall) for wall in WALLS]
    for lines in (planned.seed, planned.trajectories):
        for k, agent in enumerate(room.agents):
            path = shapely.LineString(lines.curve(k)[:, :2])
            assert min(path.distance(wall) for wall in walls) > agent.radius


def test_the_certificate_refuses_a_crossing_and_a_graze() -> None:
    room = parse_scene(ROOM.replace("METHOD", "auto"))
    through = [
        np.array([[2.0, 2, 0], [4, 8, 30]]),
        np.array([[8.0, 8, 0], [6.5, 5, 10], [1, 1, 30]]),
        np.array(
            [[8.0, 3, 0], [8, 4.8, 5], [6.5, 5, 12], [6.5, 9.6, 20], [2, 9.6, 30], [1, 9, 40]]
        ),
    ]
    found = certify(room, build_free_space(room), WorldLines.from_curves(list("abc"), through))
    broken = " ".join(found.violations)
    assert "a: leaves the free space" in broken
    assert "c: 0.0660819 m from a wall" in broken
    assert "b: " not in broken


def test_scenes_with_lines_are_hashed_by_them() -> None:
    one = parse_scene(ROOM.replace("METHOD", "auto"))
    other = parse_scene(ROOM.replace("METHOD", "auto").replace("[6, 5]", "[6.1, 5]"))
    thick = parse_scene(
        ROOM.replace("METHOD", "auto").replace("[6, 5]]}", "[6, 5]], thickness: 1}")
    )
    assert len({one.content_hash, other.content_hash, thick.content_hash}) == 3
