"""Distances of segments against a minimiser, in the plane and in space-time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from stplan.arrays import FloatArray
from tests.geometry.points import apart_squared, as_points, closest


def brute_squared_distance(p0: FloatArray, p1: FloatArray, q0: FloatArray, q1: FloatArray) -> float:
    """By a bounded minimiser from the best of a grid."""
    u, v, r = p1 - p0, q1 - q0, p0 - q0

    def gap(z: FloatArray) -> float:
        return float(((r + z[0] * u - z[1] * v) ** 2).sum())

    grid = [np.array([s, t]) for s in np.linspace(0, 1, 11) for t in np.linspace(0, 1, 11)]
    start = min(grid, key=gap)
    return min(
        gap(start), minimize(gap, start, bounds=[(0, 1), (0, 1)], options={"ftol": 1e-15}).fun
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_distance_equals_a_minimiser(dimension: int) -> None:
    rng = np.random.default_rng(0)
    for _ in range(150):
        ends = rng.normal(size=(4, dimension))
        s, t, squared = closest(*as_points(*ends))
        assert 0 <= s <= 1
        assert 0 <= t <= 1
        assert squared == pytest.approx(brute_squared_distance(*ends), abs=1e-7)
        near, far = ends[0] + s * (ends[1] - ends[0]), ends[2] + t * (ends[3] - ends[2])
        assert ((near - far) ** 2).sum() == pytest.approx(squared)


def test_points_and_parallels() -> None:
    origin, far = (0.0, 0.0, 0.0), (3.0, 4.0, 0.0)
    assert closest(origin, origin, far, far)[2] == 25
    assert closest((1.0, 2.0, 0.0), (1.0, 2.0, 0.0), origin, (4.0, 0.0, 0.0))[2] == 4
    s, t, squared = closest(origin, (4.0, 0.0, 0.0), (1.0, 1.0, 0.0), (7.0, 1.0, 0.0))
    assert squared == 1
    assert s == pytest.approx(0.625)  # the middle of the overlap [1, 4]
    assert t == pytest.approx(0.25)


def test_symmetric_and_rigid() -> None:
    rng = np.random.default_rng(1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    for _ in range(50):
        p0, p1, q0, q1 = ends = rng.normal(size=(4, 3))
        there = apart_squared(*ends)
        assert apart_squared(q0, q1, p1, p0) == pytest.approx(there)
        assert apart_squared(*(ends @ turn + [3.0, -1.0, 2.0])) == pytest.approx(there)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.integers(-3, 3).map(float), min_size=8, max_size=8))
def test_the_plane_is_space_time_at_one_instant(coordinates: list[float]) -> None:
    ends = np.array(coordinates).reshape(4, 2)
    lifted = np.column_stack([ends, np.full(4, 5.0)])
    assert apart_squared(*ends) == apart_squared(*lifted)
