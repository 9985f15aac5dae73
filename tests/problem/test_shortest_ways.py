"""Lengths that no way falls below: exact around corners, never too long, whatever the map."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.problem import shortest_ways
from stplan.problem.planning_problem import PlanningProblem, prepare
from stplan.problem.shortest_ways import shortest_lengths
from stplan.scene import parse_scene
from stplan.seeding.elastic_bands.geodesics import geodesic_curves

SCENE = """\
stplan: 1
horizon: 20.0
map: {{rectangle: [-9, -9, 9, 9], obstacles: [{obstacles}]}}
agents: [{{id: sam, start: {start}, goal: {goal}, radius: {radius}, waypoints: {waypoints}}}]
"""
BLOCK = "{rectangle: [-1, -9, 1, 1]}"


def problem_of(obstacles, start, goal, radius=0.5, waypoints=()) -> PlanningProblem:
    text = SCENE.format(
        obstacles=obstacles, start=[*start], goal=[*goal], radius=radius,
        waypoints=[[*point] for point in waypoints],
    )  # fmt: skip
    return prepare(parse_scene(text))


def lengths(*arguments, **named) -> list[float]:
    (found,) = shortest_lengths(problem_of(*arguments, **named))
    return found.tolist()


def around_a_corner(point, corner, radius: float) -> tuple[float, float]:
    """Length of the tangent from `point` to the upper half of a circle, and the angle of its foot."""
    away = np.array(point) - corner
    distance = np.hypot(*away)
    side = 1 if point[0] > corner[0] else -1
    foot = np.arctan2(away[1], away[0]) + side * np.arccos(radius / distance)
    return np.sqrt(distance**2 - radius**2), foot % (2 * np.pi)


def test_straight_ways_are_as_long_as_they_are():
    assert lengths(BLOCK, (-4, 5), (4, 5)) == pytest.approx([8.0], rel=1e-8)
    assert lengths(BLOCK, (-4, 5), (4, 5), waypoints=[(0, 8)]) == pytest.approx(
        [5.0, 5.0], rel=1e-5
    )


@pytest.mark.parametrize("radius", [0.1, 0.5, 1.5])
def test_around_a_block_tangents_and_arcs_are_exact(radius):
    """Over the block: tangent, quarter arc, along its top, quarter arc, tangent, by closed form."""
    start, goal = (-4.0, 0.0), (5.0, 0.5)
    left, foot = around_a_corner(start, (-1.0, 1.0), radius)
    right, other = around_a_corner(goal, (1.0, 1.0), radius)
    exact = left + right + 2.0 + radius * ((foot - np.pi / 2) + (np.pi / 2 - other))
    (found,) = lengths(BLOCK, start, goal, radius)
    assert found <= exact
    assert found == pytest.approx(exact, rel=1e-4)


def test_an_end_of_a_slit_is_gone_around():
    """Half a turn around the end of a wall without thickness."""
    slit = "{line: [[0, -9], [0, 0]]}"
    straight, _ = around_a_corner((-3.0, -4.0), (0.0, 0.0), 0.5)
    aside = np.arctan2(4.0, 3.0) - np.arccos(0.5 / 5.0)
    exact = 2.0 * straight + 0.5 * (np.pi + 2.0 * aside)
    (found,) = lengths(slit, (-3, -4), (3, -4))
    assert found <= exact
    assert found == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("seed", range(6))
def test_no_way_is_shorter_on_random_maps(seed):
    """Taut ways of a roadmap, which keep a little more than the radius, are longer, and not by much."""
    rng = np.random.default_rng(seed)
    blocks = []
    for _ in range(14):
        x, y = rng.uniform(-7, 7, 2)
        corners = shapely.MultiPoint(np.array([x, y]) + rng.uniform(-1.3, 1.3, (6, 2))).convex_hull
        blocks.append(f"{{polygon: {[list(p) for p in corners.exterior.coords[:-1]]}}}")
    problem = problem_of(", ".join(blocks), (-8.4, -8.4), (8.4, 8.4), 0.3)
    (way,) = geodesic_curves(problem)
    assert way is not None
    longer = float(np.hypot(*np.diff(way[:, :2], axis=0).T).sum())
    (found,) = shortest_lengths(problem)
    assert 16.8 * np.sqrt(2) * (1 - 1e-8) <= found.sum() <= longer <= 1.05 * found.sum()


def test_coarser_nodes_only_shorten_ways(monkeypatch):
    fine = lengths(BLOCK, (-4, 0), (5, 0.5))
    monkeypatch.setattr(shortest_ways, "TURNS", (np.pi / 2,))
    coarse = lengths(BLOCK, (-4, 0), (5, 0.5))
    monkeypatch.setattr(shortest_ways, "MOST_NODES", 1)
    nothing = lengths(BLOCK, (-4, 0), (5, 0.5))
    assert nothing == pytest.approx([np.hypot(9, 0.5)], rel=1e-8)
    assert nothing < coarse < fine < [1.03 * coarse[0]]


def test_many_radii_share_graphs_of_smaller_ones(monkeypatch):
    text = SCENE.format(obstacles=BLOCK, start=[-4, 0], goal=[5, 0.5], radius=0.5, waypoints=[])
    others = "".join(
        f"  - {{id: a{k}, start: [-4, {-2 - k}], goal: [5, {-2 - k}], radius: {0.1 + 0.03 * k}}}\n"
        for k in range(5)
    )
    text = text.replace("agents: [{", "agents:\n  - {").replace("}]\n", "}\n" + others)
    problem = prepare(parse_scene(text))
    own = [float(legs.sum()) for legs in shortest_lengths(problem)]
    monkeypatch.setattr(shortest_ways, "MOST_GRAPHS", 2)
    shared = [float(legs.sum()) for legs in shortest_lengths(problem)]
    assert all(0.97 * mine < other <= mine for mine, other in zip(own, shared, strict=True))
    assert shared != own


def test_the_open_plane_prescribed_motion_and_agents_that_ignore_walls():
    agents = """\
agents:
  - {id: sam, start: [-4, 0], goal: [4, 0], radius: 0.5, weights: {wall: 0}}
  - {id: ann, path: [[-4, 5, 0], [0, 6, 5], [4, 5, 9]], radius: 0.5}
"""
    head = "stplan: 1\nhorizon: 20.0\n"
    walled = f"map: {{rectangle: [-9, -9, 9, 9], obstacles: [{BLOCK}]}}\n"
    for text in (head + agents, head + walled + agents):
        sam, ann = shortest_lengths(prepare(parse_scene(text)))
        assert sam.tolist() == pytest.approx([8.0], rel=1e-8)
        assert len(ann) == 0
