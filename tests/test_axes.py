"""Time is the last axis, scaled to metres and back."""

from __future__ import annotations

import numpy as np

from stplan.axes import PLACE, TIME, in_metres, in_seconds


def test_only_time_is_scaled_and_the_curve_is_left_alone() -> None:
    curve = np.array([[1.0, 2.0, 0.0], [3.0, 5.0, 7.0]])
    positions = in_metres(curve, 1.3)
    assert np.array_equal(positions[:, PLACE], curve[:, :2])
    assert np.array_equal(positions[:, TIME], 1.3 * curve[:, 2])
    assert curve[1, TIME] == 7.0
    assert np.allclose(in_seconds(positions, 1.3), curve)
    assert positions[1, TIME] == 1.3 * 7.0


def test_a_third_dimension_of_space_comes_before_time() -> None:
    curve = np.arange(8.0).reshape(2, 4)
    assert in_metres(curve, 2.0)[:, PLACE].shape == (2, 3)
    assert in_metres(curve, 2.0)[1].tolist() == [4.0, 5.0, 6.0, 14.0]
