"""The frame near the origin changes no digit, and its bound is that of exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stplan.certify.local_frame import ERROR_SHARE, LocalFrame
from tests.certify.exact import rational

coordinate = st.floats(-1e9, 1e9)


@given(
    st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6),
    coordinate,
    st.sampled_from([1e-12, 1e-6, 1e-3, 1.0]),
)
def test_moving_the_origin_is_exact(points, shift, share) -> None:
    # Some far apart, some close together far from the origin.
    made = np.array(points) * share + [shift, -shift]
    frame = LocalFrame.around(made)
    moved = frame.local(made)
    for before, after in zip(made, moved, strict=True):
        for k in range(2):
            assert Fraction(float(before[k])) - Fraction(float(frame.origin[k])) == Fraction(
                float(after[k])
            )
    assert frame.rounding == ERROR_SHARE * np.abs(moved).max()
    extent = float(np.ptp(made, axis=0).max())
    least = max(float(np.spacing(np.abs(made).max())), 1e-150)
    assert np.abs(moved).max() <= 3.0 * max(extent, least)


def test_a_plan_around_the_origin_stays_where_it_is() -> None:
    for points in ([[0.0, 0.0], [9.0, 4.0]], [[-0.0, -3.0], [5.0, 2.0]], [[2.0, 2.0]]):
        made = np.array(points)
        frame = LocalFrame.around(made)
        if len(made) > 1:
            assert frame.local(made) is made
            assert frame.outside(made) is made
        assert np.array_equal(frame.outside(frame.local(made)), made)


def test_columns_after_the_second_are_left_alone() -> None:
    knots = np.array([[5e5, 4.6e6, 7.0], [5e5 + 8.0, 4.6e6, 9.0]])
    moved = LocalFrame.around(knots[:, :2]).local(knots)
    assert moved[:, 2].tolist() == [7.0, 9.0]
    assert np.abs(moved[:, :2]).max() < 24.0
    assert knots[0, 0] == 5e5


@pytest.mark.parametrize("northing", [0.0, 1e7, -9.9e6, 1e9])
def test_the_bound_grows_with_the_extent_not_with_the_place(northing: float) -> None:
    around = LocalFrame.around(np.array([[northing, northing], [northing + 50.0, northing]]))
    assert around.rounding < 4e-12
    assert rational(around.origin) == [Fraction(int(x)) for x in around.origin]


def test_the_bound_covers_what_the_arithmetic_may_be_off() -> None:
    # 94 units of rounding of the largest coordinate, and no more than twice that.
    frame = LocalFrame.around(np.array([[-1.0, 0.0], [1.0, 1.0]]))
    assert 94 * 2.0**-53 <= frame.rounding <= 188 * 2.0**-53


def test_the_frame_is_that_of_all_points_together() -> None:
    rng = np.random.default_rng(3)
    parts = [rng.normal(size=(4, 2)) * size + size for size in (1.0, 300.0, 5e4)]
    whole = LocalFrame.around(np.vstack(parts))
    for order in ([0, 1, 2], [2, 0, 1]):
        frame = LocalFrame.around(*(parts[k] for k in order), np.empty((0, 2)))
        assert frame.origin.tolist() == whole.origin.tolist()
        assert frame.rounding == whole.rounding
