"""Checks of first and second derivatives; each raises AssertionError with what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from stplan.arrays import FloatArray, IntArray


class Differentiable(Protocol):
    """A scalar function of (M, 3) knots with its derivatives."""

    def value(self, knots: FloatArray) -> float: ...
    def gradient(self, knots: FloatArray) -> FloatArray: ...
    def hessian_structure(self) -> tuple[IntArray, IntArray]: ...
    def hessian(self, knots: FloatArray) -> FloatArray: ...


def dense(structure: tuple[IntArray, IntArray], values: FloatArray, size: int) -> FloatArray:
    """The symmetric matrix of lower-triangle entries, repeated ones added."""
    rows, columns = structure
    assert (rows >= columns).all(), "an entry lies above the diagonal"
    lower = np.zeros((size, size))
    np.add.at(lower, (rows, columns), values)
    return lower + np.tril(lower, -1).T


def check_taylor_slopes(function: Differentiable, knots: FloatArray, rng_seed: int = 5) -> None:
    """First-order expansion errors fall with slope 2, second-order ones with slope 3, exactly.

    The expansion is along a bent curve x + h d + h^2 e / 2 + h^3 k / 6, on which no function of degree two
    is exact to second order: there is a slope to see for all of them.
    """
    rng = np.random.default_rng(rng_seed)
    along, bend, twist = 0.05 * rng.normal(size=(3, *knots.shape))
    hessian = dense(function.hessian_structure(), function.hessian(knots), knots.size)
    gradient = function.gradient(knots)
    value = function.value(knots)
    first = float((gradient * along).sum())
    second = float(along.ravel() @ hessian @ along.ravel() + (gradient * bend).sum())
    steps = 2.0 ** -np.arange(2, 18)
    shifted = np.array(
        [function.value(knots + h * along + h**2 / 2 * bend + h**3 / 6 * twist) for h in steps]
    )
    linear = np.abs(shifted - value - steps * first)
    quadratic = np.abs(shifted - value - steps * first - 0.5 * steps**2 * second)
    rounding = 1e-16 * max(abs(value), 1e-3)
    for error, order in ((linear, 2), (quadratic, 3)):
        # The smallest steps whose error is still more than rounding: wrong terms show there most.
        seen = np.flatnonzero(error > 1e3 * rounding)[-5:]
        assert len(seen) == 5, f"order {order}: the expansion never leaves rounding"
        slopes = np.diff(np.log(error[seen])) / np.diff(np.log(steps[seen]))
        assert np.abs(slopes - order).max() < 0.05, f"order {order}: slopes {slopes}"


def check_differences(function: Differentiable, knots: FloatArray) -> None:
    """Gradient against differences of values, Hessian against differences of gradients."""
    step = 1e-6
    numeric_gradient = np.empty(knots.size)
    numeric_hessian = np.empty((knots.size, knots.size))
    for k in range(knots.size):
        shift = np.zeros(knots.size)
        shift[k] = step
        shift = shift.reshape(knots.shape)
        numeric_gradient[k] = (function.value(knots + shift) - function.value(knots - shift)) / (
            2 * step
        )
        numeric_hessian[k] = (
            (function.gradient(knots + shift) - function.gradient(knots - shift)) / (2 * step)
        ).ravel()
    gradient = function.gradient(knots).ravel()
    hessian = dense(function.hessian_structure(), function.hessian(knots), knots.size)
    assert np.abs(gradient - numeric_gradient).max() <= 1e-6 * np.abs(gradient).max(), "gradient"
    assert np.abs(hessian - numeric_hessian).max() <= 1e-6 * np.abs(hessian).max(), "hessian"
    allowed = dense(function.hessian_structure(), np.ones_like(function.hessian(knots)), knots.size)
    outside = np.abs(numeric_hessian[allowed == 0])
    assert outside.max(initial=0.0) <= 1e-6 * np.abs(hessian).max(), "outside the structure"


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
