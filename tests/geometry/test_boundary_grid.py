"""The broad phase of walls against all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.geometry.boundary_grid import BoundaryGrid
from tests.geometry.points import apart_squared


@pytest.mark.parametrize("rng_seed", range(3))
def test_no_near_edge_is_missed(rng_seed: int) -> None:
    rng = np.random.default_rng(rng_seed)
    edges = rng.uniform(0, 10, (60, 2))
    edges = np.hstack([edges, edges + rng.normal(size=(60, 2))])
    starts = rng.uniform(-2, 12, (40, 2))
    ends = starts + rng.normal(size=(40, 2))
    reach = rng.uniform(0.1, 1.0, 40)
    found = [
        tuple(pair) for pair in BoundaryGrid.from_segments(edges).near(starts, ends, reach).tolist()
    ]
    assert found == sorted(set(found))
    for k in range(40):
        for e in range(60):
            if apart_squared(starts[k], ends[k], edges[e, :2], edges[e, 2:]) < reach[k] ** 2:
                assert (k, e) in found
    # And hardly any that is not near: boxes tell most of them apart.
    assert len(found) < 0.2 * 40 * 60


def test_a_reach_over_everything_finds_every_edge() -> None:
    edges = np.array([[0.0, 0, 9, 0], [9, 0, 9, 9], [9, 9, 0, 0]])
    point = np.array([[200.0, -5.0]])
    near = BoundaryGrid.from_segments(edges).near(point, point, np.array([1e12]))
    assert near.tolist() == [[0, 0], [0, 1], [0, 2]]


def test_only_the_place_of_points_in_space_time_counts() -> None:
    rng = np.random.default_rng(3)
    edges = rng.uniform(0, 10, (30, 4))
    ends = rng.uniform(0, 10, (2, 20, 3))
    walls = BoundaryGrid.from_segments(edges)
    reach = np.full(20, 0.7)
    flat = walls.near(ends[0, :, :2], ends[1, :, :2], reach)
    assert np.array_equal(walls.near(ends[0], ends[1], reach), flat)
