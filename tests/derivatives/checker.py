"""Checks of first and second derivatives; each raises AssertionError with what is wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.nlp.derivatives import Differentiable, dense, difference_faults, slope_faults

__all__ = [
    "check_differences",
    "check_not_vacuous",
    "check_structure_is_fixed",
    "check_taylor_slopes",
    "dense",
]


def check_taylor_slopes(function: Differentiable, knots: FloatArray, rng_seed: int = 5) -> None:
    """First-order expansion errors fall with slope 2, second-order ones with slope 3, exactly."""
    faults = slope_faults(function, knots, rng_seed)
    assert not faults, faults


def check_differences(function: Differentiable, knots: FloatArray) -> None:
    """Gradient against differences of values, Hessian against differences of gradients."""
    faults = difference_faults(function, knots)
    assert not faults, faults


def check_not_vacuous(function: Differentiable, knots: FloatArray) -> None:
    """Derivatives that are zero would prove nothing."""
    assert np.abs(function.gradient(knots)).max() > 1e-6, "zero gradient"
    assert np.abs(function.hessian(knots)).max() > 1e-6, "zero Hessian"


def check_structure_is_fixed(
    structure: Callable[[], tuple[IntArray, IntArray]],
    values: Callable[[FloatArray], FloatArray],
    knots: FloatArray,
    other: FloatArray,
) -> None:
    """A structure is the same wherever it is asked for, and has a place for every value."""
    before = structure()
    count = len(values(other))
    after = structure()
    assert np.array_equal(before[0], after[0])
    assert np.array_equal(before[1], after[1])
    assert (before[0] >= before[1]).all(), "an entry lies above the diagonal"
    assert count == len(values(knots)) == len(before[0])
