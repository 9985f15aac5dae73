"""What collision, wall and grouping share: contacts found by a broad phase, summed with derivatives.

A subclass says where its points are, which contacts are near, and how distances become a cost. This
base keeps the contact list up to date (renewed around whoever has moved half a skin, so the cost is exact
at every iterate), chooses the sparsity structure once from a wider list, and scatters derivatives.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.contacts.clearance_barriers import Coefficients, choose_alpha
from stplan.costs.term import Term
from stplan.geometry.contacts import (
    POINT_PAIRS,
    Measured,
    add_gradient,
    add_hessian,
    measure,
)

_FIRST = np.array([pair[0] for pair in POINT_PAIRS])
_SECOND = np.array([pair[1] for pair in POINT_PAIRS])


@dataclass(frozen=True)
class ContactList:
    """C contacts sorted by group.

    Attributes:
        points: (C, 4) indices of positions, see `stplan.geometry.contacts`.
        keys: (G,) what each group is (a pair of agents, an agent), increasing.
        starts: (G + 1,) first contact of every group.
        members: (C,) group of every contact.
    """

    points: IntArray
    keys: IntArray
    starts: IntArray
    members: IntArray

    @staticmethod
    def grouped(points: IntArray, key_of_contact: IntArray) -> ContactList:
        """Sort contacts by key, keeping the order inside a group."""
        order = np.argsort(key_of_contact, kind="stable")
        keys, first, members = np.unique(
            key_of_contact[order], return_index=True, return_inverse=True
        )
        starts = np.append(first, len(order)).astype(np.int64)
        return ContactList(np.ascontiguousarray(points[order]), keys, starts, members)


class ContactTerm(Term):
    """A term over contacts.

    Args:
        num_knots: M.
        axis_scale: (3,) derivative of a position's axis by the knot's (1, 1, c; or 1, 1, 0 in the plane).
        skin: how much further than needed lists reach, m.
        structure_skin: the same for the list that the sparsity structure is made of.
        exact_coupling: reserve the dense blocks that the exact Hessian of a smooth minimum needs.
    """

    dimension = 3

    def __init__(
        self,
        num_knots: int,
        axis_scale: FloatArray,
        skin: float,
        structure_skin: float,
        exact_coupling: bool,
    ) -> None:
        self._num_knots = num_knots
        self._axis_scale = axis_scale
        self._skin = skin
        self._structure_skin = structure_skin
        self._exact_coupling = exact_coupling
        self._listed_at = np.empty((0, 3))
        self._measured = Measured(np.empty(0), np.empty((0, 2)), np.empty((0, 3)), np.empty(0, int))
        self._coefficients = Coefficients(
            0.0, np.inf, np.empty(0), np.empty(0), np.empty(0), np.empty(0)
        )
        self._evaluated_at: FloatArray | None = None

    # What a subclass provides.

    @abstractmethod
    def positions(self, knots: FloatArray) -> FloatArray:
        """(P, 3) positions in m, the knots first."""

    @abstractmethod
    def find_contacts(self, knots: FloatArray, skin: float) -> ContactList:
        """Every contact that may matter while no position moves by more than skin / 2."""

    def renew_contacts(self, knots: FloatArray, moved: BoolArray) -> tuple[FloatArray, ContactList]:
        """The list after some knots have `moved` (M,) too far, and the knots it is now good around."""
        del moved
        return knots.copy(), self.find_contacts(knots, self._skin)

    @abstractmethod
    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """Value and chain-rule coefficients of the list's distances (C,)."""

    def feasible(self, knots: FloatArray) -> bool:
        """Further conditions on the iterate, asked after the list is up to date."""
        del knots
        return True

    # Called once by the subclass when it is ready.

    def start(self, knots: FloatArray) -> None:
        """Fix the sparsity structure around `knots`."""
        wide = self.find_contacts(knots, self._structure_skin)
        blocks = self.structure_blocks(wide)
        order = np.argsort(blocks[:, 0] * self._num_knots + blocks[:, 1])
        self._blocks = blocks[order]
        diagonal = self._blocks[:, 0] == self._blocks[:, 1]
        size = self.dimension
        lengths = np.where(diagonal, size * (size + 1) // 2, size * size)
        self._block_starts = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        self._row_starts = np.searchsorted(
            self._blocks[:, 0], np.arange(self._num_knots + 1)
        ).astype(np.int64)
        self._coupled = self._coupling_layout(wide) if self._exact_coupling else {}
        self._listed_at = knots.copy()
        if self._structure_skin != self._skin:
            wide = self.find_contacts(knots, self._skin)
        self._use(wide)

    def structure_blocks(self, wide: ContactList) -> IntArray:
        """(B, 2) pairs of knots (row >= column), unique, that get a block."""
        rows = wide.points[:, _FIRST]
        columns = wide.points[:, _SECOND]
        high, low = np.maximum(rows, columns), np.minimum(rows, columns)
        keep = (high < self._num_knots) & ((high != low) | (_FIRST == _SECOND))
        codes = np.unique(high[keep] * self._num_knots + low[keep])
        return np.column_stack([codes // self._num_knots, codes % self._num_knots])

    # Lists and evaluation.

    def _use(self, contacts: ContactList) -> None:
        self._contacts = contacts
        self._places = _locate_blocks(
            contacts.points, self._num_knots, self._row_starts,
            np.ascontiguousarray(self._blocks[:, 1]), self._block_starts,
        )  # fmt: skip
        self._evaluated_at = None

    def _evaluate(self, knots: FloatArray) -> tuple[Measured, Coefficients]:
        if self._evaluated_at is not None and np.array_equal(self._evaluated_at, knots):
            return self._measured, self._coefficients
        step = (knots - self._listed_at) * self._axis_scale
        moved = 4.0 * (step**2).sum(axis=1) > self._skin**2
        if moved.any():
            self._listed_at, contacts = self.renew_contacts(knots, moved)
            self._use(contacts)
        self._measured = measure(self.positions(knots), self._contacts.points)
        self._coefficients = self.coefficients(self._measured.distance, self._contacts)
        if not self.feasible(knots):
            self._coefficients.value = np.inf
        self._evaluated_at = knots.copy()
        return self._measured, self._coefficients

    def value(self, knots: FloatArray) -> float:
        """The cost, inf where something touches."""
        return self._evaluate(knots)[1].value

    def least_clearance(self, knots: FloatArray) -> float:
        """Smallest clearance among the contacts in m, inf where nothing is near."""
        return self._evaluate(knots)[1].least

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        measured, coefficients = self._evaluate(knots)
        result = np.zeros_like(knots)
        add_gradient(
            self._contacts.points, measured.parameters, measured.normal, coefficients.slope,
            self._axis_scale, result,
        )  # fmt: skip
        return result

    def stale(self) -> BoolArray | None:
        """Which contacts miss the structure although their curvature matters."""
        missing = (self._places == _MISSING).any(axis=1)
        curvature = self._coefficients.majorizer
        return missing & (curvature > NOTICEABLE * curvature.max(initial=0.0))

    # Second derivatives.

    def hessian_structure(self) -> tuple[IntArray, IntArray]:
        """Blocks of near knots, then the dense blocks of exact smooth minima."""
        size = self.dimension
        rows, columns = [], []
        diagonal = self._blocks[:, 0] == self._blocks[:, 1]
        x, y = np.divmod(np.arange(size * size), size)
        for same, pattern in ((True, x >= y), (False, x >= 0)):
            pick = diagonal == same
            at = (self._block_starts[:-1][pick, None] + np.arange(pattern.sum())).ravel()
            rows.append((at, (3 * self._blocks[pick, :1] + x[pattern]).ravel()))
            columns.append((at, (3 * self._blocks[pick, 1:] + y[pattern]).ravel()))
        row = np.empty(self._block_starts[-1], dtype=np.int64)
        column = np.empty_like(row)
        for at, values in rows:
            row[at] = values
        for at, values in columns:
            column[at] = values
        for variables in self._coupled.values():
            i, j = np.tril_indices(len(variables))
            row = np.append(row, variables[i])
            column = np.append(column, variables[j])
        return row, column

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact, except for contacts that miss the structure (see `stale`)."""
        return self._second(knots, exact=True)

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """Positive semidefinite stand-in: rank-one terms only, as sparse as the contacts."""
        return self._second(knots, exact=False)

    def _second(self, knots: FloatArray, exact: bool) -> FloatArray:
        measured, coefficients = self._evaluate(knots)
        values = np.zeros(int(self._block_starts[-1]))
        add_hessian(
            self.positions(knots), self._contacts.points, measured.distance,
            measured.parameters, measured.normal, measured.free, coefficients.slope,
            coefficients.curvature if exact else coefficients.majorizer, self._axis_scale,
            exact, self._places, self.dimension, values,
        )  # fmt: skip
        if not self._coupled:
            return values
        return np.concatenate([values, *self._coupling_values(measured, coefficients, exact)])

    # The dense part of the smooth minimum: coupling * grad d grad d^T, a group at a time.

    def _coupling_layout(self, wide: ContactList) -> dict[int, IntArray]:
        layout = {}
        axes = np.arange(self.dimension)
        for g, key in enumerate(wide.keys):
            knots = np.unique(wide.points[wide.starts[g] : wide.starts[g + 1]])
            knots = knots[knots < self._num_knots]
            layout[int(key)] = (3 * knots[:, None] + axes).ravel()
        return layout

    def _coupling_values(
        self, measured: Measured, coefficients: Coefficients, exact: bool
    ) -> list[FloatArray]:
        group_of = {int(key): g for g, key in enumerate(self._contacts.keys)}
        values = []
        for key, variables in self._coupled.items():
            i, j = np.tril_indices(len(variables))
            g = group_of.get(key, -1)
            if not exact or g < 0 or coefficients.coupling[g] == 0.0:
                values.append(np.zeros(len(i)))
                continue
            members = slice(self._contacts.starts[g], self._contacts.starts[g + 1])
            slope = coefficients.slope[members]
            gradient = np.zeros((self._num_knots, 3))
            add_gradient(
                self._contacts.points[members], measured.parameters[members],
                measured.normal[members], slope / slope.sum(), self._axis_scale, gradient,
            )  # fmt: skip
            part = gradient.ravel()[variables]
            values.append(coefficients.coupling[g] * part[i] * part[j])
        return values


# A contact as soft as this, against the stiffest one, may miss the Hessian for a while: it hardly
# slows the descent, and its value and gradient are exact all the same.
NOTICEABLE = 1e-2
# exp(-36) is below the rounding of a sum of order one.
NEGLIGIBLE = 36.0


def sharpened(
    contacts: ContactList,
    distance: FloatArray,
    skin: float,
    radius: FloatArray,
    alpha_0: float,
    alphas: FloatArray,
    keys: tuple[IntArray, ...],
) -> ContactList:
    """Choose alpha of groups met for the first time; drop contacts too far to weigh in a minimum.

    Args:
        distance: (C,) m, of the list's contacts.
        radius: (G,) m.
        alphas: sharpness by ``alphas[keys]`` (1/m), nan where not chosen yet; filled in place.
    """
    new = np.isnan(alphas[keys])
    if new.any():
        chosen = choose_alpha(distance, contacts.starts, radius, alpha_0)
        alphas[tuple(key[new] for key in keys)] = chosen[new]
    least = np.minimum.reduceat(distance, contacts.starts[:-1])
    limit = least + NEGLIGIBLE / alphas[keys] + 2 * skin
    keep = distance < limit[contacts.members]
    return ContactList.grouped(contacts.points[keep], contacts.keys[contacts.members[keep]])


# A block that the structure has no room for, and one that needs none (a fixed or repeated point).
_MISSING = -1
_UNNEEDED = -2


@kernel
def _locate_blocks(
    points: IntArray,
    num_knots: int,
    row_starts: IntArray,
    columns: IntArray,
    block_starts: IntArray,
) -> IntArray:
    """(C, 10) first value of every contact's blocks, `_MISSING` or `_UNNEEDED`."""
    places = np.empty((len(points), 10), dtype=np.int64)
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
                at = low + np.searchsorted(columns[low:high], column)
                found = at < high and columns[at] == column
                places[k, pair] = block_starts[at] if found else _MISSING
    return places
