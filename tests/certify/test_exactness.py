"""Computed distances against rational arithmetic, within the bound that the certificate states."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from stplan.certify.local_frame import LocalFrame
from stplan.certify.pair_clearance import nearest_moments
from stplan.certify.wall_clearance import segment_distance
from stplan.problem.world_lines import WorldLines
from tests.certify.exact import (
    adversarial_curve,
    rational,
    squared_pair_distance,
    squared_segment_distance,
    within,
)

SHIFTS = [0.0, 1e3, -4.6e6, 1e7, 1e8, 9e8]


def check_pair(first: np.ndarray, second: np.ndarray, leaves: np.ndarray) -> float:
    """Compare with the exact distance, and return how much of the bound is used up."""
    lines = WorldLines.from_curves(["a", "b"], [first, second])
    frame = LocalFrame.around(lines.knots[:, :2])
    local = lines.with_knots(frame.local(lines.knots))
    found = float(nearest_moments(local, leaves, ~np.eye(2, dtype=bool)).distance[0])
    squared = squared_pair_distance(first, second, *leaves)
    if squared is None:
        assert found == np.inf
        return 0.0
    assert within(found, squared, frame.rounding)
    share = 1.0
    while share > 1e-3 and within(found, squared, 0.5 * share * frame.rounding):
        share *= 0.5
    return share


@pytest.mark.parametrize("shift", SHIFTS)
def test_random_curves(shift: float) -> None:
    rng = np.random.default_rng(abs(int(shift)))
    for _ in range(60):
        size = 10.0 ** rng.integers(-3, 4)
        curves = [adversarial_curve(rng, size, rng.integers(2, 9)) for _ in range(2)]
        for curve in curves:
            curve[:, 0] += shift
            curve[:, 1] -= shift / 3.0
        ends = np.array([curve[-1, 2] for curve in curves])
        check_pair(*curves, ends + rng.choice([0.0, 5.0], 2))


@pytest.mark.parametrize("shift", SHIFTS)
def test_nearly_parallel_and_nearly_touching_ways(shift: float) -> None:
    rng = np.random.default_rng(abs(int(shift)) + 1)
    used = []
    for _ in range(60):
        length, angle = 10.0 ** rng.uniform(-2, 3), rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        gap, tilt = 10.0 ** rng.uniform(-13, -1), 10.0 ** rng.uniform(-13, -3)
        times = np.sort(rng.uniform(0.0, 1e3, 2))
        if times[0] == times[1]:
            continue
        heads = np.array([shift, -shift]) + np.array([np.zeros(2), length * along])
        # The other goes the same way, or against it, at almost the same speed, a hair's breadth beside.
        other = heads[:: rng.choice([1, -1])] + across * [[gap], [gap + tilt * length]]
        late = times + rng.choice([0.0, 1e-9, -1e-3], 2)
        if late[0] >= late[1]:
            continue
        curves = np.column_stack([heads, times]), np.column_stack([other, late])
        used.append(check_pair(*curves, np.array([times[1], late[1]]) + 1.0))
    # The bound is not idle: some of these come within two orders of magnitude of it.
    assert max(used) > 1e-2


def test_segments_against_edges() -> None:
    rng = np.random.default_rng(5)
    for _ in range(4000):
        size = 10.0 ** rng.uniform(-3, 3)
        points = rng.uniform(-size, size, (4, 2))
        kind = rng.integers(5)
        if kind == 0:
            # Nearly parallel, a hair's breadth apart or crossing at a tiny angle.
            points[2:] = points[:2] + rng.normal(size=(2, 2)) * size * 10.0 ** rng.uniform(-16, -4)
        elif kind == 1:
            # An end nearly on the other segment, perhaps beyond it.
            part = rng.uniform(-1e-9, 1.0 + 1e-9)
            points[2] = points[0] + part * (points[1] - points[0])
            points[2] += rng.normal(size=2) * size * 10.0 ** rng.uniform(-17, -9)
        elif kind == 2:
            # A very short one.
            points[3] = points[2] + rng.normal(size=2) * size * 10.0 ** rng.uniform(-15, -5)
        elif kind == 3:
            points[3] = points[2]
        bound = LocalFrame.around(points).rounding
        found = segment_distance(*points.ravel())
        exact = [tuple(rational(point)) for point in points]
        assert within(found, squared_segment_distance(*exact), bound)
        assert within(segment_distance(*points[[2, 3, 0, 1]].ravel()), Fraction(found) ** 2, bound)
