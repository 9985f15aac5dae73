"""The nonlinear program: terms are summed, their Hessians scattered into one structure.

Variables are the flat knots, x[3 i + axis]. A program is static data: what varies while it is solved is kept
beside it, see `stplan.nlp.step_control`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.sorting import counting_sort
from stplan.nlp.constraints import Constraints, LinearRows, linear_rows
from stplan.nlp.term import Structure, Term
from stplan.problem.layout import KnotLayout


@dataclass(frozen=True)
class NonlinearProgram:
    """Minimise the sum of terms over the knots of a layout, under bounds and linear constraints.

    Attributes:
        layout: knots and agents.
        terms: what is summed, in this order.
        constraints: bounds and linear constraints.
        exact: use every term's exact Hessian instead of its Gauss-Newton one.
        stiffness: (3 M,) what damping adds to the diagonal of the Gauss-Newton Hessian, by variable.
    """

    layout: KnotLayout
    terms: tuple[Term, ...]
    constraints: Constraints
    exact: bool = False
    stiffness: FloatArray | None = None

    @property
    def num_variables(self) -> int:
        """3 M."""
        return 3 * self.layout.num_knots

    def value(self, knots: FloatArray) -> float:
        """The objective at knots (M, 3), inf where it is undefined."""
        if not self.constraints.admits(self.layout, knots):
            return np.inf
        return self.summed(knots, self.terms)

    def summed(self, knots: FloatArray, terms: Sequence[Term]) -> float:
        """The objective of `terms`, which are this program's, renewed perhaps; time runs on in `knots`."""
        total = 0.0
        for term in terms:
            total += term.value(knots)
            if not np.isfinite(total):
                return np.inf
        return total

    def gradient(self, knots: FloatArray, terms: Sequence[Term] | None = None) -> FloatArray:
        """(M, 3) derivative of `value`."""
        own = self.terms if terms is None else terms
        total: FloatArray = np.sum([term.gradient(knots) for term in own], axis=0)
        return total

    def hessian(self, knots: FloatArray, terms: Sequence[Term] | None = None) -> FloatArray:
        """Lower triangle in the order of `hessian_structure`."""
        own = self.terms if terms is None else terms
        values = [
            term.hessian(knots) if self.exact else term.gauss_newton_hessian(knots) for term in own
        ]
        rows, _ = self.hessian_structure
        summed = np.bincount(self._merged[2], np.concatenate(values), len(rows))
        return summed.astype(np.float64, copy=False)

    @property
    def hessian_structure(self) -> Structure:
        """Rows and columns of distinct entries, row by row with increasing columns."""
        rows, columns, _ = self._merged
        return rows, columns

    @cached_property
    def diagonal(self) -> tuple[IntArray, IntArray]:
        """Places of the structure's diagonal entries, and their variables."""
        rows, columns = self.hessian_structure
        on: BoolArray = rows == columns
        places = np.flatnonzero(on)
        return places, rows[places]

    @cached_property
    def _merged(self) -> tuple[IntArray, IntArray, IntArray]:
        structures = [
            term.hessian_structure() if self.exact else term.gauss_newton_structure()
            for term in self.terms
        ]
        rows = np.concatenate([rows for rows, _ in structures])
        columns = np.concatenate([columns for _, columns in structures])
        return _merge_entries(rows, columns, self.num_variables)

    @cached_property
    def linear(self) -> LinearRows:
        """The linear constraints."""
        return linear_rows(self.layout, self.constraints)


def _merge_entries(
    rows: IntArray, columns: IntArray, size: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Distinct entries, row by row with increasing columns, and the place of every given one."""
    entries = np.empty((len(rows), 2), dtype=np.int64)
    places = np.empty(len(rows), dtype=np.int64)
    count = _fill_entries(np.column_stack([columns, rows]), size, entries, places)
    return entries[:count, 0].copy(), entries[:count, 1].copy(), places


@kernel
def _fill_entries(turned: IntArray, size: int, entries: IntArray, places: IntArray) -> int:
    """Fill `entries` and `places` (n,) for columns and rows `turned` (n, 2); the number of entries."""
    _, by_column = counting_sort(turned, size)
    for k in range(len(turned)):
        entries[k, 0] = turned[by_column[k], 1]
        entries[k, 1] = turned[by_column[k], 0]
    _, by_row = counting_sort(entries, size)
    count = 0
    row = column = -1
    for k in by_row:
        given = by_column[k]
        if turned[given, 1] != row or turned[given, 0] != column:
            row = turned[given, 1]
            column = turned[given, 0]
            count += 1
        places[given] = count - 1
    for k in range(len(turned)):
        entries[places[k], 0] = turned[k, 1]
        entries[places[k], 1] = turned[k, 0]
    return count
