"""Checks of first and second derivatives; each raises AssertionError with what is wrong."""

from __future__ import annotations

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


def check_taylor_slopes(function: Differentiable, knots: FloatArray, direction: FloatArray) -> None:
    """First-order expansion errors fall with slope 2, second-order ones with slope 3."""
    hessian = dense(function.hessian_structure(), function.hessian(knots), knots.size)
    value = function.value(knots)
    first = float((function.gradient(knots) * direction).sum())
    second = float(direction.ravel() @ hessian @ direction.ravel())
    steps = 2.0 ** -np.arange(3, 9)
    shifted = np.array([function.value(knots + h * direction) for h in steps])
    linear = np.abs(shifted - value - steps * first)
    quadratic = np.abs(shifted - value - steps * first - 0.5 * steps**2 * second)
    # Below rounding an error of zero has no slope: there the expansion is exact.
    floor = 1e-12 * max(abs(value), 1.0)
    for error, order in ((linear, 2), (quadratic, 3)):
        use = error > 100 * floor
        if use.sum() < 3:
            assert error.max() <= 1e3 * floor or order == 3, "the expansion never leaves rounding"
            continue
        slopes = np.diff(np.log(error[use])) / np.diff(np.log(steps[use]))
        assert np.median(slopes) > order - 0.3, f"order {order}: slopes {slopes}"


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
    function: Differentiable, knots: FloatArray, other: FloatArray
) -> None:
    """The structure is the same wherever it is asked for."""
    before = function.hessian_structure()
    count = len(function.hessian(other))
    after = function.hessian_structure()
    assert np.array_equal(before[0], after[0])
    assert np.array_equal(before[1], after[1])
    assert count == len(function.hessian(knots)) == len(before[0])
