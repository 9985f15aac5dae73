"""Chains of 3x3 blocks: symmetric positive definite systems of one elastic band, solved in place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inlined
from stplan.geometry.allocation import new_number_rows, new_numbers

# Knots: free, pinned in the plane but free in time, fixed.
FREE, PINNED, FIXED = 0, 1, 2


class Chain(NamedTuple):
    """A block tridiagonal system of a chain of knots, with room for K of them.

    Attributes:
        diagonal: (K, 3, 3).
        upper: (K, 3, 3) where upper[i] couples knots i and i + 1; the last one is not used.
        force: (K, 3) right-hand side, and the solution in the end.
        inverse: (K, 3, 3) working memory of the elimination.
    """

    diagonal: FloatArray
    upper: FloatArray
    force: FloatArray
    inverse: FloatArray


@inlined
def make_chain(num_knots: int) -> Chain:
    """Room for a chain of `num_knots`."""
    return Chain(
        np.empty((num_knots, 3, 3)),
        np.empty((num_knots, 3, 3)),
        new_number_rows(num_knots, 3),
        np.empty((num_knots, 3, 3)),
    )


@inlined
def clear(chain: Chain, num_knots: int) -> None:
    """Set the first `num_knots` rows of the system to zero."""
    for i in range(num_knots):
        for x in range(3):
            chain.force[i, x] = 0.0
            for y in range(3):
                chain.diagonal[i, x, y] = 0.0
                chain.upper[i, x, y] = 0.0


@inlined
def hold_knots(hold: IntArray, chain: Chain) -> None:
    """Take the coordinates that may not move out of the system of a chain of knots `hold` (n,)."""
    diagonal, upper, force = chain.diagonal, chain.upper, chain.force
    for i in range(len(hold)):
        held = 0 if hold[i] == FREE else (2 if hold[i] == PINNED else 3)
        for x in range(held):
            force[i, x] = 0.0
            for y in range(3):
                diagonal[i, x, y] = 0.0
                diagonal[i, y, x] = 0.0
                upper[i, x, y] = 0.0
                if i > 0:
                    upper[i - 1, y, x] = 0.0
            diagonal[i, x, x] = 1.0


@inlined
def solve(chain: Chain, num_knots: int) -> None:
    """Solve the system of the first `num_knots` knots in place; `force` becomes the solution."""
    diagonal, upper, force, inverse = chain
    carry = new_number_rows(3, 3)
    for i in range(num_knots):
        if i > 0:
            # carry = upper[i - 1]^T inverse[i - 1], the elimination of the knot before.
            for x in range(3):
                for y in range(3):
                    carry[x, y] = 0.0
                    for z in range(3):
                        carry[x, y] += upper[i - 1, z, x] * inverse[i - 1, z, y]
            for x in range(3):
                for y in range(3):
                    force[i, x] -= carry[x, y] * force[i - 1, y]
                    for z in range(3):
                        diagonal[i, x, y] -= carry[x, z] * upper[i - 1, z, y]
        _invert(diagonal[i], inverse[i])
    rest = new_numbers(3)
    for i in range(num_knots - 1, -1, -1):
        for x in range(3):
            rest[x] = force[i, x]
            if i < num_knots - 1:
                for y in range(3):
                    rest[x] -= upper[i, x, y] * force[i + 1, y]
        for x in range(3):
            force[i, x] = (
                inverse[i, x, 0] * rest[0] + inverse[i, x, 1] * rest[1] + inverse[i, x, 2] * rest[2]
            )


@inlined
def _invert(block: FloatArray, inverse: FloatArray) -> None:
    """Inverse of a symmetric positive definite 3x3 block."""
    a, b, c = block[0, 0], block[0, 1], block[0, 2]
    d, e, f = block[1, 1], block[1, 2], block[2, 2]
    first = d * f - e * e
    second = c * e - b * f
    third = b * e - c * d
    scale = 1.0 / (a * first + b * second + c * third)
    inverse[0, 0] = first * scale
    inverse[0, 1] = inverse[1, 0] = second * scale
    inverse[0, 2] = inverse[2, 0] = third * scale
    inverse[1, 1] = (a * f - c * c) * scale
    inverse[1, 2] = inverse[2, 1] = (b * c - a * e) * scale
    inverse[2, 2] = (a * d - b * b) * scale
