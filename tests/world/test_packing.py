"""Places that cannot hold all who stay in them."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.scene import parse_scene
from stplan.world import build_free_space, check_scene_in_world
from stplan.world.packing import most_apart
from stplan.world.places import spots

TRIANGLE = shapely.Polygon([(0, 0), (3, 0), (1.5, 1.5 * np.sqrt(3))])


@pytest.mark.parametrize(
    ("room", "most"),
    [
        (shapely.Polygon(), 0),
        (shapely.Point(1, 1), 1),
        (shapely.LineString([(0, 0), (3, 0)]), 4),
        (shapely.LineString([(0, 0), (3, 0), (3, 2.9)]), 6),
        # The triangular numbers are reached.
        (TRIANGLE, 10),
        (shapely.union_all([TRIANGLE, shapely.affinity.translate(TRIANGLE, 50, 0)]), 20),
        # Tiny parts beside each other hold no more than the hull of all.
        (shapely.MultiPoint([(0, 0), (0.01, 0), (0.02, 0)]), 1),
    ],
)
def test_known_rooms(room: shapely.Geometry, most: int) -> None:
    assert most_apart(room, 1.0) == most


@pytest.mark.parametrize("seed", range(5))
def test_no_set_of_spots_is_larger(seed: int) -> None:
    corners = np.random.default_rng(seed).uniform(0, 6, (7, 2))
    room = shapely.buffer(shapely.LineString(corners), 0.4)
    found = spots(room, 0.5, 0.01)
    assert 0 < len(found) <= most_apart(room, 0.5)


def faults(agents: str, *, top: str = "map: {rectangle: [0, 0, 10, 6]}") -> list[str]:
    scene = parse_scene(
        f"stplan: 1\nhorizon: 40\n{top}\nplaces:\n  hall: {{rectangle: [0, 0, 5, 6]}}\n"
        "  nook: {rectangle: [8, 2, 10, 4]}\n  bench: {line: [[6, 1], [9, 1]]}\n"
        f"defaults: {{radius: 0.25}}\nagents:\n{agents}"
    )
    return check_scene_in_world(scene, build_free_space(scene) if scene.map else None)


def crowd(count: int, goal: str, more: str = "", name: str = "p") -> str:
    return f"  - {{id: {name}, count: {count}, start: {{place: hall}}, goal: {goal}{more}}}\n"


def test_more_than_fit_are_refused_at_their_entry() -> None:
    assert faults(crowd(7, "{place: bench}")) == []
    assert faults(crowd(8, "{place: bench}")) == [
        "scene:10:45: agents[0].goal: place bench has room for at most 7 who stay 0.5 m apart, not for 8"
    ]
    # Walls take their part of the nook.
    assert faults(crowd(24, "{place: nook}")) == []
    (text,) = faults(crowd(25, "{place: nook}"))
    assert "place nook has room for at most 24" in text
    (text,) = faults(crowd(8, "{place: bench}"), top="")
    assert "place bench has room for at most 7" in text


def test_crowds_of_one_place_count_together() -> None:
    two = crowd(5, "{place: bench}") + crowd(3, "{place: bench}", name="q")
    (text,) = faults(two)
    assert "agents[0].goal: place bench" in text
    assert "not for 8" in text
    either = crowd(29, "{any: [bench, nook]}") + crowd(3, "{place: bench}", name="q")
    (text,) = faults(either)
    assert "agents[0].goal: place bench and place nook have room for at most 31" in text
    assert "not for 32" in text


def test_who_leaves_or_overlaps_needs_no_room() -> None:
    assert faults(crowd(40, "{place: bench}", ", after_arrival: vanish")) == []
    assert faults(crowd(40, "{place: bench}", ", weights: {collision: 0}")) == []
