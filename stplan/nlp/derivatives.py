"""Whether derivatives are those of the value: by central differences and by slopes of Taylor expansions."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from stplan.arrays import FloatArray
from stplan.errors import DerivativeError
from stplan.nlp.term import Structure

STEP = 1e-6
# What differences may be off, relative to the largest entry.
TOLERANCE = 1e-6
# The order of what is left of an expansion, and how far its slope may be from that.
_ORDERS, _OFF = {"gradient": 2, "Hessian": 3}, 0.05
_SEEN = 5


class Differentiable(Protocol):
    """A scalar function of (M, 3) knots with its derivatives; the Hessian as entries of a lower triangle."""

    def value(self, knots: FloatArray) -> float:
        """At `knots`."""
        ...

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        ...

    def hessian_structure(self) -> Structure:
        """Rows and columns, variable 3 i + axis; row >= column."""
        ...

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Their values; repeated entries add."""
        ...


def check_derivatives(function: Differentiable, knots: FloatArray, *, rng_seed: int = 0) -> None:
    """Check the gradient and the exact Hessian of a cost at `knots` (M, 3).

    Central differences of the value must be the gradient, those of the gradient the Hessian, with nothing
    outside its structure; what is left of the first- and second-order Taylor expansions must fall with the
    second and third power of the step. The check refuses a point at which derivatives are zero: that would
    prove nothing.

    Raises:
        DerivativeError: with all that does not fit.
    """
    faults = [
        *vacuous_faults(function, knots),
        *difference_faults(function, knots),
        *slope_faults(function, knots, rng_seed),
    ]
    if faults:
        raise DerivativeError(faults)


def dense(structure: Structure, values: FloatArray, size: int) -> FloatArray:
    """The symmetric matrix of lower-triangle entries, repeated ones added."""
    rows, columns = structure
    lower = np.zeros((size, size))
    np.add.at(lower, (rows, columns), values)
    symmetric: FloatArray = lower + np.tril(lower, -1).T
    return symmetric


def vacuous_faults(function: Differentiable, knots: FloatArray) -> list[str]:
    """Derivatives that are zero."""
    found = {"gradient": function.gradient(knots), "Hessian": function.hessian(knots)}
    return [
        f"the {name} is zero here: choose other knots"
        for name, values in found.items()
        if not np.abs(values).max(initial=0.0) > 0
    ]


def difference_faults(function: Differentiable, knots: FloatArray) -> list[str]:
    """What differs from central differences, and what is outside the structure."""
    rows, columns = function.hessian_structure()
    if (rows < columns).any():
        return ["the structure has an entry above the diagonal"]
    slope, bend = np.empty(knots.size), np.empty((knots.size, knots.size))
    for k in range(knots.size):
        shift = np.zeros(knots.size)
        shift[k] = STEP
        ahead, behind = knots + shift.reshape(knots.shape), knots - shift.reshape(knots.shape)
        slope[k] = (function.value(ahead) - function.value(behind)) / (2 * STEP)
        bend[k] = (function.gradient(ahead) - function.gradient(behind)).ravel() / (2 * STEP)
    gradient, values = function.gradient(knots).ravel(), function.hessian(knots)
    hessian = dense((rows, columns), values, knots.size)
    outside = dense((rows, columns), np.ones_like(values), knots.size) == 0
    off = {
        "the gradient is not the difference of values": (gradient - slope, gradient),
        "the Hessian is not the difference of gradients": (hessian - bend, hessian),
        "there is curvature outside the structure": (bend[outside], hessian),
    }
    return [
        f"{what}: off by {np.abs(error).max():.3g}"
        for what, (error, size) in off.items()
        if not np.abs(error).max(initial=0.0) <= TOLERANCE * np.abs(size).max(initial=0.0)
    ]


def slope_faults(function: Differentiable, knots: FloatArray, rng_seed: int) -> list[str]:
    """Expansions along a bent curve, on which no function of degree two is exact, with wrong slopes."""
    along, bend, twist = 0.05 * np.random.default_rng(rng_seed).normal(size=(3, *knots.shape))
    hessian = dense(function.hessian_structure(), function.hessian(knots), knots.size)
    gradient, value = function.gradient(knots), function.value(knots)
    first = float((gradient * along).sum())
    second = float(along.ravel() @ hessian @ along.ravel() + (gradient * bend).sum())
    steps = 2.0 ** -np.arange(2, 18)
    shifted = np.array(
        [function.value(knots + h * along + h**2 / 2 * bend + h**3 / 6 * twist) for h in steps]
    )
    linear = np.abs(shifted - value - steps * first)
    left = {
        "gradient": linear,
        "Hessian": np.abs(shifted - value - steps * first - steps**2 / 2 * second),
    }
    rounding = 1e-16 * max(abs(value), 1e-3)
    faults = []
    for name, error in left.items():
        # The smallest steps whose error is still more than rounding: wrong derivatives show there most.
        seen = np.flatnonzero(error > 1e3 * rounding)[-_SEEN:]
        if len(seen) < _SEEN:
            faults.append(f"{name}: the expansion never leaves rounding; choose other knots")
            continue
        slopes = np.diff(np.log(error[seen])) / np.diff(np.log(steps[seen]))
        if not np.abs(slopes - _ORDERS[name]).max() < _OFF:
            wanted = f"{_ORDERS[name]} is expected"
            faults.append(f"{name}: slopes {np.round(slopes, 2).tolist()}, where {wanted}")
    return faults
