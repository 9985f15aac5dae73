"""Penalties of times that are not as they should be: what leads a seed to visits and meetings on time.

For knots i, j with low <= t_j - t_i <= high asked for (i = -1 stands for time 0), the cost is
weight / 2 times the square of what is missing, in s. It is convex and has curvature only where
something is missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.formulation import TermSetup, TimedConstraints
from stplan.costs.registry import register
from stplan.nlp.term import Capability, Structure, Term

NONE = -1
# Times count as kept at this share of the inset that the penalty aims at, those of meetings at the other.
CONTENT, CONTENT_APART = 0.5, 0.25


@dataclass(frozen=True)
class Intervals:
    """(N,) least and greatest difference of times, s."""

    low: FloatArray
    high: FloatArray

    def missing(self, difference: FloatArray) -> FloatArray:
        """(N,) signed seconds outside: positive too late, negative too early."""
        return np.maximum(difference - self.high, 0.0) - np.maximum(self.low - difference, 0.0)


@register(rank=120)
class Timing(Term):
    """Half the squared seconds by which differences of times miss their intervals.

    Args:
        knots: (N, 2) i and j, i = `NONE` for the time of j itself.
        aim: the intervals that times are drawn into.
        weight: per s^2.
        num_knots: M.
        content: the wider ones in which they count as kept, `aim` by default.
        asked: those that the scene asks for, `aim` by default.
    """

    name = "timing"
    capabilities = Capability.LIMIT | Capability.RESTORING

    def __init__(
        self,
        knots: IntArray,
        aim: Intervals,
        weight: float,
        num_knots: int,
        *,
        content: Intervals | None = None,
        asked: Intervals | None = None,
    ) -> None:
        self._first, self._second = knots[:, 0], knots[:, 1]
        self._absolute = self._first == NONE
        self._aim = aim
        self._content, self._asked = content or aim, asked or aim
        self._weight = weight
        self._num_knots = num_knots

    @classmethod
    def build(cls, setup: TermSetup) -> Timing | None:
        """Where feasibility is restored; elsewhere the constraints keep all times."""
        penalties, timed = setup.penalties, setup.formulation.timed
        if penalties is None:
            return None
        alone = np.column_stack([np.full_like(timed.windowed, NONE), timed.windowed])
        return cls(
            np.vstack([alone, timed.stays, timed.links]),
            _intervals(timed, penalties.inset, 0.0),
            penalties.timing,
            setup.formulation.layout.num_knots,
            content=_intervals(timed, CONTENT * penalties.inset, CONTENT_APART * penalties.inset),
            asked=_intervals(timed, 0.0, 0.0),
        )

    def _difference(self, knots: FloatArray) -> FloatArray:
        earlier = np.where(self._absolute, 0.0, knots[self._first, 2])
        difference: FloatArray = knots[self._second, 2] - earlier
        return difference

    def missing(self, knots: FloatArray) -> FloatArray:
        """(N,) signed seconds outside the intervals aimed at."""
        return self._aim.missing(self._difference(knots))

    def is_kept(self, knots: FloatArray) -> bool:
        """Whether all times are as they should be, with a little to spare."""
        return not self._content.missing(self._difference(knots)).any()

    def state(self, knots: FloatArray) -> str:
        """By how much times are missed, in words."""
        late = np.abs(self._asked.missing(self._difference(knots))).max(initial=0.0)
        return f"times {late:.2g} s off"

    def value(self, knots: FloatArray) -> float:
        """The cost."""
        return float(0.5 * self._weight * (self.missing(knots) ** 2).sum())

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3); only times matter."""
        slope = self._weight * self.missing(knots)
        result = np.zeros((self._num_knots, 3))
        np.add.at(result[:, 2], self._second, slope)
        np.add.at(result[:, 2], self._first, np.where(self._absolute, 0.0, -slope))
        return result

    def hessian_structure(self) -> Structure:
        """(t_j, t_j), then (t_i, t_i) and the mixed entry of relative ones."""
        pair = ~self._absolute
        low = np.minimum(self._first, self._second)[pair]
        high = np.maximum(self._first, self._second)[pair]
        rows = np.concatenate([self._second, self._first[pair], high])
        columns = np.concatenate([self._second, self._first[pair], low])
        return 3 * rows + 2, 3 * columns + 2

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of the structure."""
        stiff = np.where(self.missing(knots) != 0.0, self._weight, 0.0)
        pair = stiff[~self._absolute]
        return np.concatenate([stiff, pair, -pair])

    def gauss_newton_structure(self) -> Structure:
        """That of the Hessian."""
        return self.hessian_structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The exact one, which is positive semidefinite."""
        return self.hessian(knots)


def _intervals(timed: TimedConstraints, inset: float, apart: float) -> Intervals:
    """Visits at least `inset` inside their times, meetings at most `apart` (s)."""
    inside = np.minimum(inset, 0.25 * np.ptp(timed.window, axis=1))
    links = np.full(len(timed.links), apart)
    no_end = np.full(len(timed.dwell), np.inf)
    return Intervals(
        np.concatenate([timed.window[:, 0] + inside, timed.dwell + inset, -links]),
        np.concatenate([timed.window[:, 1] - inside, no_end, links]),
    )
