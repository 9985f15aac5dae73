"""Distances to places, and crowds that share out points."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.certify.places import broken_assignments, distance_outside, outside_all
from stplan.scene import parse_scene
from stplan.scene.places import Place

HOOK = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (3.0, 3.0), (3.0, 1.0), (0.0, 1.0))


# Without an edge along an axis.
KITE = ((2.5, -0.5), (4.5, 1.0), (1.5, 3.5), (2.0, 1.5))
# A corner is said twice, as in rings that are closed.
CLOSED = (*HOOK, HOOK[0])


@pytest.mark.parametrize("area", [True, False])
@pytest.mark.parametrize("ring", [HOOK, KITE, CLOSED])
def test_distances_are_those_of_a_polygon_or_of_its_line(ring: tuple, area: bool) -> None:
    place = Place("exit", ring, area)
    shape = shapely.Polygon(ring) if area else shapely.LineString(ring)
    rng = np.random.default_rng(4)
    points = np.vstack([rng.uniform(-1.0, 5.0, (200, 2)), [[3.5, 2.0], [0.0, 0.5], [2.0, 1.0]]])
    for point in points:
        exact = shapely.distance(shape, shapely.Point(point))
        assert distance_outside(place, point) == pytest.approx(exact, abs=1e-12)


def test_an_end_outside_names_the_place_and_how_far_it_is() -> None:
    places = [Place("west", ((0.0, 0.0), (0.0, 2.0)), False), Place("hall", HOOK, True)]
    assert outside_all(places, np.array([3.5, 2.0]), 1e-9) == ""
    assert outside_all(places, np.array([0.0, 1.5]), 1e-9) == ""
    said = outside_all(places, np.array([4.0 + 1.0 / 3.0, 2.0]), 1e-9)
    assert said == "ends at (4.333333, 2), 0.333 m outside place west or place hall"


def test_a_point_is_for_one_of_a_crowd() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 9\nagents:\n"
        "  - {id: c, count: 2, start: {points: [[0, 0], [0, 2]]}, goal: {assign: [[8, 0], [8, 2]]}}\n"
    )
    assert broken_assignments(scene, np.array([[8.0, 2.0], [8.0, 0.0]])) == []
    twice = broken_assignments(scene, np.array([[8.0, 2.0], [8.0, 2.0]]))
    assert [sentence.partition(": ")[2] for sentence in twice] == [
        "ends at (8.0, 2.0), which is another's already"
    ]
    nowhere = broken_assignments(scene, np.array([[8.0, 2.0], [8.0, 1.0]]))
    assert [sentence.partition(": ")[2] for sentence in nowhere] == [
        "ends at (8.0, 1.0), which is none of its crowd's points"
    ]
