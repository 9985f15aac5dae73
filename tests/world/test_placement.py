"""Whether scenes fit their maps: located messages and radii known in closed form."""

from __future__ import annotations

import re

import numpy as np
import pytest

from stplan.world import (
    build_free_space,
    check_scene_in_world,
    cut_off_agents,
    widest_passage,
)
from stplan.world.placement import EROSION_SAFETY
from tests.world.scenes import scene

BOX = "{rectangle: [0, 0, 10, 4]}"


def messages(agents: str, world: str = BOX) -> list[str]:
    """What the check says."""
    built = scene(world, agents)
    return check_scene_in_world(built, build_free_space(built))


def blocked(radius: float, gap: float, *waypoints: tuple[float, float]) -> float | None:
    """The widest radius that gets through a doorway of width `gap`, None if the agent's own does."""
    walls = f"{{rectangle: [4, -1, 5, {2 - gap / 2}]}}, {{rectangle: [4, {2 + gap / 2}, 5, 5]}}"
    world = f"{{rectangle: [0, 0, 10, 4], obstacles: [{walls}]}}"
    built = scene(world, "  - {id: a, start: [2, 2], goal: [8, 2], radius: 0.1}")
    space = build_free_space(built)
    assert space is not None
    stops = np.array([(2.0, 2.0), *waypoints, (8.0, 2.0)])
    if not cut_off_agents(space, [stops], np.array([radius])):
        return None
    return widest_passage(space, stops, radius)


def test_a_scene_that_fits() -> None:
    assert messages("  - {id: a, start: [1, 1], goal: [9, 1], waypoints: [[5, 2]]}") == []


def test_messages_have_place_and_numbers() -> None:
    found = messages(
        "  - {id: a, start: [0.2, 1], goal: [12, 1], radius: 0.5}\n"
        "  - {id: b, start: [2, 2], goal: [9, 3], waypoints: [[5, 2], [5, 4.5]]}"
    )
    assert len(found) == 3
    assert re.match(r"scene:5:\d+: agents\[0\]\.start: \(0\.2, 1\) is 0\.2 m from a wall", found[0])
    assert "the radius is 0.5 m" in found[0]
    assert re.match(r"scene:5:\d+: agents\[0\]\.goal: \(12, 1\) lies outside .* by 2 m", found[1])
    assert re.match(r"scene:6:\d+: agents\[1\]\.waypoints\[1\]: \(5, 4\.5\) lies outside", found[2])


def test_touching_a_wall_is_not_enough() -> None:
    assert len(messages("  - {id: a, start: [0.5, 1], goal: [5, 1], radius: 0.5}")) == 1


def test_given_paths_are_checked_and_walls_may_be_off() -> None:
    path = "path: [[1, 1, 0], [1, 9, 1], [2, 1, 2]]"
    assert "agents[0].path[1]" in messages(f"  - {{id: a, {path}}}")[0]
    assert messages(f"  - {{id: a, {path}, weights: {{wall: 0}}}}") == []
    assert messages("  - {id: a, start: [90, 1], goal: [1, 1]}", world="") == []


def test_the_widest_radius_is_half_the_gap() -> None:
    assert blocked(0.5, 0.8) == pytest.approx(0.4, rel=2 * EROSION_SAFETY)


@pytest.mark.parametrize(("radius", "passes"), [(0.39, True), (0.4, True), (0.402, False)])
def test_a_way_is_never_denied_by_rounding(radius: float, passes: bool) -> None:
    assert (blocked(radius, 0.8) is None) is passes


def test_separate_parts() -> None:
    assert blocked(0.2, -1.0) == 0.0
    assert blocked(0.2, -1.0, (2.0, 1.0)) == 0.0


def test_who_has_no_stops_or_no_walls_is_never_cut_off() -> None:
    none = np.empty((0, 2))
    space = build_free_space(scene(BOX, "  - {id: a, start: [2, 2], goal: [8, 2]}"))
    assert cut_off_agents(space, [none], np.array([0.5])) == []
    far = np.array([(2.0, 2.0), (80.0, 2.0)])
    assert cut_off_agents(None, [far], np.array([0.5])) == []
    assert cut_off_agents(space, [none, far], np.array([0.5, 0.5])) == [1]
