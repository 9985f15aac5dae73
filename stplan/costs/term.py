"""What every term of the objective offers to the problem that sums them."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray

# Lower triangle of a 3 x 3 diagonal block, and a full off-diagonal one, row by row.
_LOWER = np.array([(x, y) for x in range(3) for y in range(x + 1)])
_FULL = np.array([(x, y) for x in range(3) for y in range(3)])


class Term(ABC):
    """One cost of the paper over all agents.

    Knots are (M, 3) arrays of x, y [m], t [s]; variable 3 i + x is axis x of knot i. A value of inf
    says that the term is undefined there (a rod inside another, time running back).
    """

    name: str

    @abstractmethod
    def value(self, knots: FloatArray) -> float:
        """The cost, inf outside its domain."""

    @abstractmethod
    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3) derivative of `value`."""

    @abstractmethod
    def hessian_structure(self) -> tuple[IntArray, IntArray]:
        """Rows and columns (row >= column) of the lower triangle's entries; fixed for life."""

    @abstractmethod
    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of `hessian_structure`; repeated entries add."""

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """What the optimiser uses by default: the exact Hessian unless a term has a better model."""
        return self.hessian(knots)

    def stale(self) -> BoolArray | None:
        """Which interactions lie outside the structure and are felt, None where that cannot be."""
        return None


def block_structure(rows: IntArray, columns: IntArray) -> tuple[IntArray, IntArray]:
    """Variables of 3 x 3 blocks of knots (row knot >= column knot), in the order of `pack_blocks`.

    Diagonal blocks (row == column) hold their lower triangle. All blocks of one call are of one kind.
    """
    pattern = _LOWER if len(rows) and rows[0] == columns[0] else _FULL
    row = 3 * rows[:, None] + pattern[:, 0]
    column = 3 * columns[:, None] + pattern[:, 1]
    return row.ravel(), column.ravel()


def pack_blocks(blocks: FloatArray, diagonal: bool) -> FloatArray:
    """Values of (B, 3, 3) blocks in the order of `block_structure`."""
    pattern = _LOWER if diagonal else _FULL
    return np.ascontiguousarray(blocks[:, pattern[:, 0], pattern[:, 1]]).ravel()
