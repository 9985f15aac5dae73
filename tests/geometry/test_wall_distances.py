"""Distances to walls against shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.arrays import FloatArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.grid import make_query
from stplan.geometry.wall_distances import (
    clear_of_walls,
    least_wall_distance,
    least_wall_distances,
)

ROOM = shapely.box(0, 0, 10, 8).difference(
    shapely.union_all([shapely.box(3, 2, 5, 5), shapely.Point(7, 6).buffer(0.8)])
)


def edges_of(polygon: shapely.Polygon) -> FloatArray:
    rings = [polygon.exterior, *polygon.interiors]
    corners = [np.asarray(ring.coords) for ring in rings]
    return np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in corners])


WALLS = BoundaryGrid.from_segments(edges_of(ROOM))


def random_segments(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Short and long segments in and around the room, and their distance to its boundary."""
    rng = np.random.default_rng(8)
    starts = rng.uniform(-1, 11, (count, 2))
    ends = starts + rng.normal(size=(count, 2)) * rng.choice([0.0, 0.3, 3.0], (count, 1))
    lines = shapely.linestrings(np.stack([starts, ends], axis=1))
    return starts, ends, shapely.distance(lines, ROOM.boundary)


def test_distances_up_to_a_reach_equal_shapely() -> None:
    starts, ends, exact = random_segments(200)
    found = least_wall_distances(starts, ends, 1.5, WALLS)
    assert found == pytest.approx(np.minimum(exact, 1.5), abs=1e-9)


def test_the_least_of_the_near_ones_is_the_least() -> None:
    starts, ends, exact = random_segments(40)
    for k in range(40):
        one = slice(k, k + 1)
        near = WALLS.near(starts[one], ends[one], np.array([2.0]))
        least = least_wall_distance(starts[one], ends[one], near, WALLS.edges)
        if exact[k] < 2.0:
            assert least == pytest.approx(exact[k], abs=1e-9)
    nothing = np.empty((0, 2), dtype=np.int64)
    assert least_wall_distance(starts, ends, nothing, WALLS.edges) == np.inf


def test_clear_of_walls_means_further_than_the_gap() -> None:
    starts, ends, exact = random_segments(200)
    query = make_query(WALLS.grid.cells)
    found = [clear_of_walls(p, q, 0.4, WALLS, query) for p, q in zip(starts, ends, strict=True)]
    assert found == (exact > 0.4).tolist()
    assert 20 < sum(found) < 180
    assert clear_of_walls(starts[0], ends[0], -1.0, WALLS, query)
