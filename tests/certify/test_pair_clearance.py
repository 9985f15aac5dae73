"""The closed-form pair distance against dense sampling and analytic cases."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.pair_clearance import nearest_moments
from stplan.problem.world_lines import WorldLines


def least(curves, leaves=None) -> tuple[float, float]:
    """Least distance and its time of two curves."""
    lines = WorldLines.from_curves(["a", "b"], [np.array(c, dtype=float) for c in curves])
    ends = [c[-1, 2] for c in lines.curves()]
    found = nearest_moments(
        lines, np.array(ends if leaves is None else leaves, dtype=float), ~np.eye(2, dtype=bool)
    )
    assert found.pairs.tolist() == [[0, 1]]
    if np.isfinite(found.distance[0]):
        places = [
            [np.interp(found.instant[0], curve[:, 2], curve[:, x]) for x in range(2)]
            for curve in lines.curves()
        ]
        assert found.middle[0] == pytest.approx(np.mean(places, axis=0), abs=1e-9)
    return float(found.distance[0]), float(found.instant[0])


def sampled(first, second, begin, end) -> float:
    """The same by 20001 samples."""
    times = np.linspace(begin, end, 20001)
    gap = [
        np.interp(times, first[:, 2], first[:, x]) - np.interp(times, second[:, 2], second[:, x])
        for x in range(2)
    ]
    return float(np.hypot(*gap).min())


def test_head_on_with_an_offset() -> None:
    there = [[0, 0, 0], [10, 0, 10]]
    back = [[10, 0.7, 0], [0, 0.7, 10]]
    assert least([there, back]) == pytest.approx((0.7, 5.0))


def test_crossing_at_different_times_is_no_collision() -> None:
    # At time t they are at (t, 0) and (5, 8 - t): the relative position is (t - 5, t - 8).
    gap, when = least([[[0, 0, 0], [10, 0, 10]], [[5, 8, 0], [5, -2, 10]]])
    assert gap == pytest.approx(3 / np.sqrt(2))
    assert when == pytest.approx(6.5)


def test_a_staying_agent_is_met_on_its_goal_and_a_vanished_one_is_not() -> None:
    parked = [[0, 0, 0], [1, 0, 1]]
    passing = [[-8, 0.2, 0], [12, 0.2, 20]]
    assert least([parked, passing], [20, 20])[0] == pytest.approx(0.2)
    assert least([parked, passing])[0] > 7
    assert least([parked, passing], [20, 20])[1] == pytest.approx(9.0)


def test_never_present_together() -> None:
    assert least([[[0, 0, 0], [1, 0, 1]], [[0, 0, 2], [1, 0, 3]]])[0] == np.inf


@pytest.mark.parametrize("rng_seed", range(20))
def test_random_polylines_against_sampling(rng_seed: int) -> None:
    rng = np.random.default_rng(rng_seed)
    curves = []
    for _ in range(2):
        count = rng.integers(2, 12)
        times = np.cumsum(rng.uniform(0.05, 1.5, count)) + rng.uniform(0, 1)
        curves.append(np.column_stack([rng.normal(size=(count, 2)) * 3, times]))
    begin = max(curve[0, 2] for curve in curves)
    leaves = [curve[-1, 2] + rng.uniform(0, 3) for curve in curves]
    end = min(leaves)
    if end < begin:
        leaves = [leave + 20 for leave in leaves]
        end = min(leaves)
    exact, when = least(curves, leaves)
    brute = sampled(*curves, begin, end)
    assert exact <= brute + 1e-12
    assert exact == pytest.approx(brute, abs=5e-3)
    assert begin <= when <= end
    assert sampled(*curves, when, when) == pytest.approx(exact, abs=1e-9)
    assert least(curves[::-1], leaves[::-1])[0] == pytest.approx(exact, abs=1e-12)
