"""Distances of rods against all pairs of their segments."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.geometry.rod_distances import closest_points, rod_distance, segment_distances
from tests.geometry.points import apart_squared


def random_rod(rng: np.random.Generator, count: int) -> FloatArray:
    """A rod with rising times."""
    return np.column_stack([rng.uniform(0, 10, (count, 2)), np.sort(rng.uniform(0, 20, count))])


def distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """(n - 1, m - 1) of all pairs of segments, m."""
    return np.sqrt(
        [
            [apart_squared(*first[i : i + 2], *second[j : j + 2]) for j in range(len(second) - 1)]
            for i in range(len(first) - 1)
        ]
    )


def test_of_all_pairs_the_least_up_to_the_limit() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        first, second = random_rod(rng, 6), random_rod(rng, 9)
        least = distances(first, second).min()
        assert rod_distance(first, second, 50.0) == pytest.approx(least)
        assert rod_distance(first, second, 0.5) == pytest.approx(min(least, 0.5))
        near, far = closest_points(first, second)
        assert np.linalg.norm(near - far) == pytest.approx(least)
        assert distances(np.stack([near, near]), first).min() == pytest.approx(0, abs=1e-9)
        assert distances(np.stack([far, far]), second).min() == pytest.approx(0, abs=1e-9)


def test_of_the_pairs_asked_for() -> None:
    rng = np.random.default_rng(1)
    positions = rng.uniform(0, 5, (9, 3))
    segments = rng.integers(0, 9, (7, 2))
    pairs = rng.integers(0, 7, (12, 2))
    found = segment_distances(positions, segments, pairs)
    for k, (i, j) in enumerate(pairs):
        expected = apart_squared(*positions[segments[i]], *positions[segments[j]])
        assert found[k] == pytest.approx(np.sqrt(expected))
