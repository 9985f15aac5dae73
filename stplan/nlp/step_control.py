"""What varies while a program is solved: the iterate, how far steps may go from it, damping, and clocks.

The program itself is a pure function of the knots. A solver asks this object instead, which refuses further
points (by a value of inf) so that every accepted iterate is a valid plan of the seed's homotopy class:

- No step uses up nearly all of the least clearance, or of what any limit leaves: without this
  fraction-to-the-boundary rule a long step can land a hair's breadth from contact, where the barrier is too
  steep to ever leave again.
- Nothing is crossed on the straight way from the last iterate.

After steps that clearances have cut short the Hessian is damped, as Levenberg and Marquardt do: it knows
nothing of how distances bend, and undamped its steps along contacts are far longer than it holds true.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.nlp.program import NonlinearProgram
from stplan.nlp.term import Capability, Term

# A step keeps at least this share of the smallest clearance, and of the slack of every limit.
KEPT_SHARE = 0.2
# Shares of the full step below which damping grows, and above which it falls; by which factors.
SHORT_STEP, LONG_STEP = 0.3, 0.7
HARDER, SOFTER = 10.0, 0.5
LEAST_DAMPING = 0.1


@dataclass
class Stopwatch:
    """Seconds spent in evaluations; never part of a repeatable file.

    Attributes:
        parts: s of processor time that parts of a problem took which were optimised on their own.
    """

    objective: float = 0.0
    hessian: float = 0.0
    evaluations: int = 0
    refused: int = 0
    parts: float = 0.0


class StepControl:
    """The changing part of one run of a solver.

    Args:
        program: what is solved.
        knots: (M, 3) feasible, the first iterate.
        damping: factor on the program's stiffness in the Gauss-Newton Hessian.
        watch: adds up over several runs.
    """

    def __init__(
        self,
        program: NonlinearProgram,
        knots: FloatArray,
        *,
        damping: float = 0.0,
        watch: Stopwatch | None = None,
    ) -> None:
        self.program = program
        self.damping = damping
        self.watch = Stopwatch() if watch is None else watch
        self._terms = program.terms
        self._key: bytes | None = None
        self._value = np.inf
        self._gradient: FloatArray | None = None
        # Whether clearances have refused a step since the last iterate.
        self._touched = False
        # A new program is a chance to step further: it starts out less damped than the last one ended.
        self.accept(knots.ravel())

    @property
    def iterate(self) -> FloatArray:
        """(M, 3) the last accepted knots."""
        return self._iterate

    @property
    def terms(self) -> tuple[Term, ...]:
        """The program's terms, as they were prepared for the latest point asked for."""
        return self._terms

    def value(self, x: FloatArray) -> float:
        """The objective at flat knots x (3 M,), inf where no step may lead."""
        self._evaluate(x)
        return self._value

    def gradient(self, x: FloatArray) -> FloatArray:
        """(3 M,) derivative of the objective."""
        self._evaluate(x)
        started = time.perf_counter()
        if self._gradient is None:
            self._gradient = self.program.gradient(x.reshape(-1, 3), self._terms).ravel()
        self.watch.objective += time.perf_counter() - started
        return self._gradient

    def hessian(self, x: FloatArray) -> FloatArray:
        """Damped lower triangle in the order of the program's structure."""
        started = time.perf_counter()
        summed = self.program.hessian(x.reshape(-1, 3), self._terms)
        stiffness = self.program.stiffness
        if self.damping and stiffness is not None and not self.program.exact:
            places, variables = self.program.diagonal
            summed[places] += self.damping * stiffness[variables]
        self.watch.hessian += time.perf_counter() - started
        return summed

    def accept(self, x: FloatArray, share: float = 1.0) -> None:
        """Take `x` (3 M,) as the iterate to step from, reached by a `share` of the full step."""
        if share < SHORT_STEP and self._touched:
            self.damping = max(HARDER * self.damping, LEAST_DAMPING)
        elif share > LONG_STEP:
            self.damping = SOFTER * self.damping if self.damping > LEAST_DAMPING else 0.0
        self._touched = False
        knots = x.reshape(-1, 3)
        self._iterate = knots.copy()
        least = self.least_clearance(knots)
        self._floor = KEPT_SHARE * least if np.isfinite(least) else 0.0

    def is_stale(self) -> bool:
        """Whether an interaction that is felt at the iterate has no room in the Hessian's structure."""
        return any(term.is_stale(self._iterate) for term in self._terms)

    def least_clearance(self, knots: FloatArray) -> float:
        """Smallest clearance that a barrier feels, m; inf where none is felt."""
        return min((term.least_clearance(knots) for term in self._terms), default=np.inf)

    def _evaluate(self, x: FloatArray) -> None:
        key = x.tobytes()
        if key == self._key:
            return
        started = time.perf_counter()
        self._key = key
        self._gradient = None
        self.watch.evaluations += 1
        knots = x.reshape(-1, 3)
        self._value = np.inf
        if self.program.constraints.admits(self.program.layout, knots):
            self._value = self._tried(knots)
        if not np.isfinite(self._value):
            self.watch.refused += 1
        self.watch.objective += time.perf_counter() - started

    def _tried(self, knots: FloatArray) -> float:
        """All terms together, inf where one is undefined, uses up too much of its room or is crossed."""
        total = 0.0
        terms = list(self._terms)
        for place, term in enumerate(terms):
            if term.touches(knots):
                total = np.inf
            else:
                terms[place] = term.renewed(knots)
                total += terms[place].value(knots)
            if not np.isfinite(total):
                self._terms = tuple(terms)
                self._touched |= Capability.CLEARANCE in term.capabilities
                return np.inf
        self._terms = tuple(terms)
        if self.least_clearance(knots) < self._floor:
            self._touched = True
            return np.inf
        if not all(term.leaves_slack(self._iterate, knots, KEPT_SHARE) for term in terms):
            return np.inf
        for term in terms:
            if not term.allows_step(self._iterate, knots):
                self._touched = True
                return np.inf
        return total
