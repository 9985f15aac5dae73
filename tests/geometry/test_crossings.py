"""Crossings of plane segments against their distance, and touching ones."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.geometry.crossings import crossings, segments_cross
from tests.geometry.points import apart_squared


def test_crossings_agree_with_zero_distance() -> None:
    rng = np.random.default_rng(4)
    starts, ends = rng.uniform(0, 4, (2, 300, 2))
    edges = rng.uniform(0, 4, (300, 4))
    index = np.arange(300)
    crossed = crossings(starts, ends, np.column_stack([index, index]), edges)
    assert crossed.tolist() == [
        apart_squared(starts[k], ends[k], edges[k, :2], edges[k, 2:]) < 1e-18 for k in range(300)
    ]
    assert 30 < crossed.sum() < 200


@pytest.mark.parametrize(
    ("other", "meets"),
    [
        ([[1, -1], [1, 1]], True),
        ([[2, 0], [3, 1]], True),  # an end on an end
        ([[1, 0], [1, 5]], True),  # an end inside
        ([[1, 0], [3, 0]], True),  # overlapping on one line
        ([[2.5, 0], [3, 0]], False),  # apart on one line
        ([[0, 1], [2, 1]], False),
        ([[3, -1], [3, 1]], False),
        ([[1, 1e-9], [1, 1]], False),
        ([[1, 0], [1, 0]], True),  # a point on it
    ],
)
def test_touching_counts(other: list[list[float]], meets: bool) -> None:
    a, b = (0.0, 0.0), (2.0, 0.0)
    p, q = (tuple(map(float, point)) for point in other)
    assert segments_cross(a, b, p, q) == meets
    assert segments_cross(q, p, b, a) == meets


def turned(angle: float) -> FloatArray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("angle", [0.3, 1.9, 4.0])
def test_turning_and_moving_changes_nothing(angle: float) -> None:
    rng = np.random.default_rng(2)
    ends = rng.uniform(0, 4, (200, 4, 2))
    pairs = np.column_stack([np.arange(200), np.arange(200)])

    def crossed(points: FloatArray) -> FloatArray:
        return crossings(
            points[:, 0].copy(), points[:, 1].copy(), pairs, points[:, 2:].reshape(-1, 4)
        )

    assert np.array_equal(crossed(ends), crossed(ends @ turned(angle).T + [5.0, -2.0]))
