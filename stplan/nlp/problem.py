"""The nonlinear program: terms are summed, their Hessians scattered into one structure.

Variables are the flat knots, x[3 i + axis]. Start, goal, waypoints and given paths are fixed by equal
bounds and T^max is a bound. That time runs on is part of the objective's domain: the regularity cost rises
without bound as a duration goes to zero. Where no such cost stands guard (a weight of 0, a dwell) a least
t_{i+1} - t_i is a linear constraint with a constant Jacobian, as is t_i = t_j of the knots at which a pair
meets. Constraints for all segments would double the size of the linear systems.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.costs.contacts.contact_term import ContactTerm
from stplan.costs.limit import Limit
from stplan.costs.term import Term
from stplan.problem.layout import KnotLayout

# A step keeps at least this share of the smallest clearance.
CLEARANCE_KEPT = 0.2
# Shares of the full step below which damping grows, and above which it falls; by which factors.
SHORT_STEP, LONG_STEP = 0.3, 0.7
HARDER, SOFTER = 10.0, 0.5
LEAST_DAMPING = 0.1


@dataclass(frozen=True)
class Limits:
    """What a plan must keep whatever it costs.

    Attributes:
        lower, upper: (M, 3) bounds of the knots, equal where a variable is fixed.
        least_duration: (S,) smallest t_{i+1} - t_i of every segment, s.
        guarded: (G,) segments whose least duration takes a constraint of its own.
        links: (L, 2) knots of one time.
        greatest_share: (S,) largest part of the whole duration that a segment may last, inf for any.
    """

    lower: FloatArray
    upper: FloatArray
    least_duration: FloatArray
    guarded: IntArray
    links: IntArray
    greatest_share: FloatArray


@dataclass
class Stopwatch:
    """Seconds spent in evaluations; never part of a repeatable file."""

    objective: float = 0.0
    hessian: float = 0.0
    evaluations: int = 0
    refused: int = 0


@dataclass
class Problem:
    """Sum of terms over one layout of knots.

    Args:
        layout: knots and agents.
        terms: what is summed.
        limits: bounds and least durations.
        exact: use every term's exact Hessian instead of its Gauss-Newton one.
        stiffness: (3 M,) what damping adds to the diagonal of the Gauss-Newton Hessian, by variable.
        damping: factor on it at the start.
    """

    layout: KnotLayout
    terms: Sequence[Term]
    limits: Limits
    exact: bool = False
    watch: Stopwatch = field(default_factory=Stopwatch)
    stiffness: FloatArray | None = None
    damping: float = 0.0

    def __post_init__(self) -> None:
        structures = [term.hessian_structure() for term in self.terms]
        rows = np.concatenate([rows for rows, _ in structures])
        columns = np.concatenate([columns for _, columns in structures])
        self.hessian_rows, self.hessian_columns, self._place = _merged(
            rows, columns, self.num_variables
        )
        self._linear()
        self._diagonal = np.flatnonzero(self.hessian_rows == self.hessian_columns)
        self._key: bytes | None = None
        self._value = np.inf
        self._gradient: FloatArray | None = None
        self._floor = 0.0
        self._slack_floor = 0.0
        # Whether contacts have refused a step since the last iterate.
        self._touched = False

    @property
    def num_variables(self) -> int:
        """3 M."""
        return 3 * self.layout.num_knots

    def value(self, x: FloatArray) -> float:
        """The objective at flat knots x (3 M,), inf where it is undefined."""
        self._evaluate(x)
        return self._value

    def accept(self, x: FloatArray, share: float = 1.0) -> None:
        """Take `x` as the iterate to step from, reached by a `share` of the full step.

        No step from it may use up nearly all its clearance: without this fraction-to-the-boundary rule
        a long step can land a hair's breadth from contact, where the barrier is too steep to ever leave
        again. After steps that contacts have cut short the Hessian is damped, as Levenberg and Marquardt
        do: it knows nothing of how distances bend, and undamped its steps along contacts are far longer
        than it holds true.
        """
        if share < SHORT_STEP and self._touched:
            self.damping = max(HARDER * self.damping, LEAST_DAMPING)
        elif share > LONG_STEP:
            self.damping = SOFTER * self.damping if self.damping > LEAST_DAMPING else 0.0
        self._touched = False
        knots = x.reshape(-1, 3)
        least = self._least_clearance(knots)
        self._floor = CLEARANCE_KEPT * least if np.isfinite(least) else 0.0
        slack = self._least_slack(knots)
        self._slack_floor = CLEARANCE_KEPT * slack if np.isfinite(slack) else 0.0

    def _least_clearance(self, knots: FloatArray) -> float:
        contacts = [term for term in self.terms if isinstance(term, ContactTerm)]
        return min((term.least_clearance(knots) for term in contacts), default=np.inf)

    def _least_slack(self, knots: FloatArray) -> float:
        barred = [term for term in self.terms if isinstance(term, Limit) and term.barred]
        return min((term.least_slack(knots) for term in barred), default=np.inf)

    def gradient(self, x: FloatArray) -> FloatArray:
        """(3 M,) derivative of `value`."""
        self._evaluate(x)
        started = time.perf_counter()
        if self._gradient is None:
            knots = x.reshape(-1, 3)
            self._gradient = np.sum([term.gradient(knots) for term in self.terms], axis=0).ravel()
        self.watch.objective += time.perf_counter() - started
        return self._gradient

    def _evaluate(self, x: FloatArray) -> None:
        key = x.tobytes()
        if key == self._key:
            return
        started = time.perf_counter()
        self._key = key
        self._gradient = None
        self.watch.evaluations += 1
        self._value = np.inf
        knots = x.reshape(-1, 3)
        if self._admissible(knots):
            self._value = self._sum(knots)
        if not np.isfinite(self._value):
            self.watch.refused += 1
        self.watch.objective += time.perf_counter() - started

    def _sum(self, knots: FloatArray) -> float:
        """All terms together, inf where one is undefined or uses up too much of its room."""
        total = 0.0
        for term in self.terms:
            total += term.value(knots)
            if not np.isfinite(total):
                self._touched |= isinstance(term, ContactTerm)
                return np.inf
        if self._least_clearance(knots) < self._floor:
            self._touched = True
            return np.inf
        return total if self._least_slack(knots) >= self._slack_floor else np.inf

    def _admissible(self, knots: FloatArray) -> bool:
        """Finite, with time running on: asked before any term may divide by a duration."""
        start = self.layout.segment
        duration = knots[start + 1, 2] - knots[start, 2]
        # Half of it: a constraint of Ipopt holds to a tolerance.
        return bool(
            np.isfinite(knots).all() and (duration > 0.5 * self.limits.least_duration).all()
        )

    def hessian(self, x: FloatArray) -> FloatArray:
        """Lower triangle in the order of `hessian_rows`, `hessian_columns`."""
        started = time.perf_counter()
        knots = x.reshape(-1, 3)
        values = np.concatenate(
            [
                term.hessian(knots) if self.exact else term.gauss_newton_hessian(knots)
                for term in self.terms
            ]
        )
        summed = _summed(values, self._place, len(self.hessian_rows))
        if self.damping and self.stiffness is not None and not self.exact:
            variables = self.hessian_rows[self._diagonal]
            summed[self._diagonal] += self.damping * self.stiffness[variables]
        self.watch.hessian += time.perf_counter() - started
        return summed

    def constraints(self, x: FloatArray) -> FloatArray:
        """(G + L + E,) in s: t_{i+1} - t_i of guarded segments, t_j - t_i of links, and what limited
        durations leave of their shares.
        """
        rows, columns, values = self._jacobian
        return np.bincount(rows, values * x[columns], len(self._bounds[0])).astype(np.float64)

    def constraints_jacobian(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows, columns and (constant) values of the Jacobian of `constraints`."""
        return self._jacobian

    def constraint_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest of `constraints`, s."""
        return self._bounds

    def _linear(self) -> None:
        """Set up the linear constraints."""
        limits, segment = self.limits, self.layout.segment
        start, links = segment[limits.guarded], limits.links
        even = np.flatnonzero(np.isfinite(limits.greatest_share))
        agent, share = self.layout.agent_of_segment[even], limits.greatest_share[even]
        head = np.concatenate([start, links[:, 0], segment[even] + 1, self.layout.first[agent]])
        tail = np.concatenate([start + 1, links[:, 1], segment[even], self.layout.last[agent]])
        num_plain = len(start) + len(links)
        row = np.concatenate([np.arange(num_plain + len(even)), num_plain + np.arange(len(even))])
        weight = np.concatenate([np.ones(num_plain + len(even)), share])
        columns = np.column_stack([3 * head + 2, 3 * tail + 2]).ravel()
        # A segment at an end of its curve has an entry twice: they are added.
        codes, place = np.unique(
            np.repeat(row, 2) * self.num_variables + columns, return_inverse=True
        )
        values = np.bincount(place, np.column_stack([-weight, weight]).ravel(), len(codes))
        rows, columns = np.divmod(codes, self.num_variables)
        self._jacobian = (rows, columns, values.astype(np.float64))
        none, same = np.full(len(start), 2e19), np.zeros(len(links))
        least = limits.least_duration[limits.guarded]
        self._bounds = (
            np.concatenate([least, same, np.zeros(len(even))]),
            np.concatenate([none, same, np.full(len(even), 2e19)]),
        )

    def is_stale(self) -> bool:
        """Whether a felt interaction has no room in the Hessian's structure."""
        for term in self.terms:
            missing: BoolArray | None = term.stale()
            if missing is not None and missing.any():
                return True
        return False


@kernel
def _merged(rows: IntArray, columns: IntArray, size: int) -> tuple[IntArray, IntArray, IntArray]:
    """Distinct entries, row by row with increasing columns, and the place of every given one."""
    starts = np.zeros(size + 1, dtype=np.int64)
    for row in rows:
        starts[row + 1] += 1
    for row in range(size):
        starts[row + 1] += starts[row]
    sequence = np.empty(len(rows), dtype=np.int64)
    filled = starts[:-1].copy()
    for k in range(len(rows)):
        sequence[filled[rows[k]]] = k
        filled[rows[k]] += 1
    places = np.empty(len(rows), dtype=np.int64)
    entries = np.empty((len(rows), 2), dtype=np.int64)
    count = 0
    for row in range(size):
        own = sequence[starts[row] : starts[row + 1]]
        before = -1
        for k in own[np.argsort(columns[own])]:
            if columns[k] != before:
                before = columns[k]
                entries[count, 0] = row
                entries[count, 1] = before
                count += 1
            places[k] = count - 1
    return entries[:count, 0].copy(), entries[:count, 1].copy(), places


@kernel
def _summed(values: FloatArray, places: IntArray, count: int) -> FloatArray:
    """(count,) sums of the values that go to the same place."""
    total = np.zeros(count)
    for k in range(len(values)):
        total[places[k]] += values[k]
    return total
