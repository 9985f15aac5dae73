"""Outlines that cross far too often are known before anything is made of them."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.maps.formats.crossings import lines_tangle, shapes_tangle

# Each of these crosses most others.
RAYS = [
    np.array([[np.cos(a), np.sin(a)], [-np.cos(a), -np.sin(a)]]) for a in np.linspace(0, 3, 1000)
]


def test_lines_that_cross_all_others_are_a_tangle() -> None:
    assert lines_tangle(RAYS)
    assert shapes_tangle([shapely.linestrings(ray) for ray in RAYS])


def test_neighbours_places_and_copies_are_none() -> None:
    circle = shapely.Point(0, 0).buffer(1, quad_segs=2000)
    assert not shapes_tangle([circle, circle, shapely.Point(5, 0).buffer(1, quad_segs=2000)])
    assert not shapes_tangle([shapely.Point(k, 0) for k in range(2000)])
    assert not lines_tangle([])
    assert not shapes_tangle([])


def test_holes_are_not_joined_with_each_other() -> None:
    holes = [shapely.box(x, y, x + 0.5, y + 0.5) for x in range(1, 40) for y in range(1, 40)]
    floor = shapely.difference(shapely.box(0, 0, 41, 41), shapely.union_all(holes))
    assert not shapes_tangle([floor])
