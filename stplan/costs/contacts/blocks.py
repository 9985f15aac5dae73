"""Where the second derivatives of contacts go: a sparsity structure that is fixed once.

Blocks between near knots come first, in the order of their knots; a diagonal block holds its lower triangle.
The exact Hessian of smooth minima adds a dense lower triangle for every group.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.contacts.contact_set import ContactList, distinct
from stplan.costs.contacts.potential import Coefficients
from stplan.geometry.allocation import new_integer_rows
from stplan.geometry.contacts import POINT_PAIRS, Measured, add_gradient
from stplan.geometry.sorting import first_at_least
from stplan.nlp.term import Structure

_FIRST = np.array([pair[0] for pair in POINT_PAIRS])
_SECOND = np.array([pair[1] for pair in POINT_PAIRS])
# A block that the structure has no room for, and one that needs none (a fixed or repeated point).
MISSING = -1
_UNNEEDED = -2


def near_blocks(contacts: ContactList, num_knots: int) -> ContactBlocks:
    """Between all knots that contacts join."""
    rows = contacts.points[:, _FIRST]
    columns = contacts.points[:, _SECOND]
    high, low = np.maximum(rows, columns), np.minimum(rows, columns)
    keep = (high < num_knots) & ((high != low) | (_FIRST == _SECOND))
    codes = distinct(high[keep] * num_knots + low[keep])
    blocks = np.column_stack([codes // num_knots, codes % num_knots])
    return ContactBlocks(blocks, num_knots, dimension=3)


@dataclass(frozen=True)
class ContactBlocks:
    """Blocks between knots.

    Attributes:
        blocks: (B, 2) pairs of knots (row >= column), unique.
        num_knots: M.
        dimension: axes of a knot that contacts move, 3, or 2 in the plane.
    """

    blocks: IntArray
    num_knots: int
    dimension: int

    @cached_property
    def _sorted(self) -> IntArray:
        order = np.argsort(self.blocks[:, 0] * self.num_knots + self.blocks[:, 1])
        return np.ascontiguousarray(self.blocks[order])

    @cached_property
    def _starts(self) -> IntArray:
        """(B + 1,) first value of every block."""
        size = self.dimension
        diagonal = self._sorted[:, 0] == self._sorted[:, 1]
        lengths = np.where(diagonal, size * (size + 1) // 2, size * size)
        return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)

    @property
    def num_values(self) -> int:
        """Length of the values."""
        return int(self._starts[-1])

    def structure(self) -> Structure:
        """Rows and columns of the values."""
        size, blocks = self.dimension, self._sorted
        row = np.empty(self.num_values, dtype=np.int64)
        column = np.empty_like(row)
        diagonal = blocks[:, 0] == blocks[:, 1]
        x, y = np.divmod(np.arange(size * size), size)
        for same, pattern in ((True, x >= y), (False, x >= 0)):
            pick = diagonal == same
            at = (self._starts[:-1][pick, None] + np.arange(pattern.sum())).ravel()
            row[at] = (3 * blocks[pick, :1] + x[pattern]).ravel()
            column[at] = (3 * blocks[pick, 1:] + y[pattern]).ravel()
        return row, column

    def places(self, contacts: ContactList) -> IntArray:
        """(C, 10) first value of every contact's blocks, negative (`MISSING`) where there is none."""
        rows, columns = self._rows, self._columns
        return _locate_blocks(contacts.points, self.num_knots, rows, columns, self._starts)

    @cached_property
    def _rows(self) -> IntArray:
        """(M + 1,) first block of every row of knots."""
        return np.searchsorted(self._sorted[:, 0], np.arange(self.num_knots + 1)).astype(np.int64)

    @cached_property
    def _columns(self) -> IntArray:
        return np.ascontiguousarray(self._sorted[:, 1])


def own_blocks(segments: IntArray, num_knots: int) -> ContactBlocks:
    """Every segment's own blocks: walls couple nothing else, so this structure is never stale."""
    first, second = segments, segments + 1
    own = np.union1d(first, second)
    blocks = np.vstack([np.column_stack([own, own]), np.column_stack([second, first])])
    return ContactBlocks(blocks, num_knots, dimension=2)


@dataclass(frozen=True)
class DenseCoupling:
    """coupling * grad d grad d^T of smooth minima, a dense lower triangle a group.

    Attributes:
        wide: contacts whose groups and knots get room.
        num_knots: M.
        dimension: as for `ContactBlocks`.
    """

    wide: ContactList
    num_knots: int
    dimension: int

    @cached_property
    def _variables(self) -> dict[int, IntArray]:
        """Variables of every group, by its key."""
        found = {}
        axes = np.arange(self.dimension)
        for g, key in enumerate(self.wide.keys):
            knots = np.unique(self.wide.points[self.wide.starts[g] : self.wide.starts[g + 1]])
            knots = knots[knots < self.num_knots]
            found[int(key)] = (3 * knots[:, None] + axes).ravel()
        return found

    def structure(self) -> Structure:
        """Rows and columns of the values."""
        rows, columns = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
        for variables in self._variables.values():
            i, j = np.tril_indices(len(variables))
            rows.append(variables[i])
            columns.append(variables[j])
        return np.concatenate(rows), np.concatenate(columns)

    def values(
        self,
        contacts: ContactList,
        measured: Measured,
        coefficients: Coefficients,
        axis_scale: FloatArray,
    ) -> FloatArray:
        """The values at one iterate; groups without room are left out."""
        group_of = {int(key): g for g, key in enumerate(contacts.keys)}
        values = [np.empty(0)]
        for key, variables in self._variables.items():
            i, j = np.tril_indices(len(variables))
            g = group_of.get(key, -1)
            if g < 0 or coefficients.coupling[g] == 0.0:
                values.append(np.zeros(len(i)))
                continue
            members = slice(contacts.starts[g], contacts.starts[g + 1])
            slope = coefficients.slope[members]
            gradient = np.zeros((self.num_knots, 3))
            add_gradient(
                contacts.points[members], measured.at(members), slope / slope.sum(),
                axis_scale, gradient,
            )  # fmt: skip
            part = gradient.ravel()[variables]
            values.append(coefficients.coupling[g] * part[i] * part[j])
        return np.concatenate(values)


@kernel
def _locate_blocks(
    points: IntArray,
    num_knots: int,
    row_starts: IntArray,
    columns: IntArray,
    block_starts: IntArray,
) -> IntArray:
    """(C, 10) first value of every contact's blocks, `MISSING` or `_UNNEEDED`."""
    places = new_integer_rows(len(points), 10)
    for k in range(len(points)):
        pair = -1
        for i in range(4):
            for j in range(i + 1):
                pair += 1
                row = max(points[k, i], points[k, j])
                column = min(points[k, i], points[k, j])
                if row >= num_knots or (i != j and row == column):
                    places[k, pair] = _UNNEEDED
                    continue
                low = row_starts[row]
                high = row_starts[row + 1]
                at = first_at_least(columns, low, high, column)
                found = at < high and columns[at] == column
                places[k, pair] = block_starts[at] if found else MISSING
    return places
