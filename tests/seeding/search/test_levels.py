"""Levels: roadmaps that leave nobody without a way that the walls leave it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from stplan.planner import plan, prepare
from stplan.scene.model import Scene
from stplan.seeding.search.levels import Levels
from tests.seeding import tight_families as families


def gap(slack: float, radii: list[float], thick: float = 0.2) -> Scene:
    """Two rooms with a gap wider than the largest agent by a share of `slack`."""
    half = max(radii) * (1.0 + slack)
    walls = [
        families.rectangle(4.9, 0, 4.9 + thick, 3 - half),
        families.rectangle(4.9, 3 + half, 4.9 + thick, 6),
    ]
    starts = [1.2, 3.1, 4.8]
    journeys = [((1.0, y), (9.0, y)) for y in starts[: len(radii)]]
    room = families.rectangle(0, 0, 10, 6)
    return families.make_scene("gap", room, walls, journeys, radii=radii)


@pytest.mark.parametrize("thick", [0.05, 0.4, 2.0])
@pytest.mark.parametrize("slim", [0.05, 0.12, 0.25, 0.29])
def test_no_radius_loses_a_gap_to_another(slim: float, thick: float) -> None:
    for slack in (0.01, 0.02, 0.03):
        levels = Levels(prepare(gap(slack, [slim, 0.3, 0.8 * slim], thick)))
        level = levels.at(1.05)
        assert level.journeys.stranded() == []
        assert (level.required.walls > levels.problem.radii).all()


@pytest.mark.parametrize(("slack", "thick"), [(1e-3, 2.0), (1e-4, 0.2), (1e-5, 0.2)])
def test_gaps_hardly_wider_than_an_agent_are_passed_by_a_whole_plan(
    slack: float, thick: float
) -> None:
    result = plan(gap(slack, [0.25, 0.3], thick))
    assert result.exit_status == 0
    assert result.certificate.holds


def test_agents_a_millionth_of_a_metre_off_walls_and_each_other_are_planned() -> None:
    near, far = 0.4 + 1e-6, 1.2 + 2e-6
    journeys = [
        ((near, near), (8 - near, 6 - near)),
        ((far, near), (8 - near, near)),
        ((near, far), (8 - near, 6 - far)),
        ((7.0, 3.0), (1.0, 3.0)),
    ]
    room = families.rectangle(0, 0, 8, 6)
    result = plan(families.make_scene("corner", room, [], journeys, radii=0.4))
    assert result.exit_status == 0
    assert result.certificate.holds


# Of the smallest there are more points than a roadmap may have: it is seven times as coarse as they ask for.
@pytest.mark.parametrize("radius", [0.05, 0.25, 0.3])
def test_roadmaps_among_pillars_hold_ways_as_short_as_there_are(radius: float) -> None:
    count, pitch = 8, 3.0
    angle = 2 * np.pi * np.arange(24) / 24
    ring = 0.9 * np.column_stack([np.cos(angle), np.sin(angle)])
    middles = pitch * np.stack(np.meshgrid(np.arange(count), np.arange(count)), 2).reshape(-1, 2)
    pillars = [tuple(map(tuple, (middle + ring).tolist())) for middle in middles]
    far = pitch * count
    journeys = [((-1.5, y), (far - 1.5, far - 2.9 - y)) for y in (1.5, 7.4, 13.6)]
    room = families.rectangle(-3, -3, far, far)
    levels = Levels(prepare(families.make_scene("pillars", room, pillars, journeys, radii=radius)))
    level = levels.at(1.05)
    graph = level.graph
    for agent, way in enumerate(levels.ways):
        assert way is not None
        journey = level.journeys.of[agent]
        moves = np.flatnonzero(journey.free)
        lengths = csr_array(
            (graph.length[moves], (graph.move_from[moves], graph.move_to[moves])),
            shape=(graph.num_vertices, graph.num_vertices),
        )
        reached = dijkstra(lengths, indices=[journey.start])[0, journey.targets[-1]]
        assert way.length <= reached * (1 + 1e-9)
        assert reached < 1.02 * way.length
