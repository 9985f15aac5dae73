"""Regularity cost: C^R_a = K^R_a sum_i (T/n) / dt_i with T = t_n - t_0   (the paper's regularizer).

Its least value is K^R n, reached where all dt are equal; very short segments cost without bound.
Through T the arrival time couples to every knot of the agent: an arrow in the Hessian. With
e_i = 1/dt_i and S = sum e_i:  f = (K/n) T S,  f_TT = 0,  d/d(dt_i) = -(K/n) T e_i^2,
d2/d(dt_i)2 = 2 (K/n) T e_i^3,  d2/(dT d dt_i) = -(K/n) e_i^2.  The start time t_0 is a constant.

f does not change when all times are stretched, so its Hessian is indefinite wherever the dt differ. The
Gauss-Newton one keeps the diagonal of (dt_i) alone: positive semidefinite, and without the arrow, whose rows
would fill the factors of the whole problem.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout


@register(rank=20)
class Regularity(Term):
    """Keeps the knots of every agent spread evenly in time."""

    name = "regularity"
    capabilities = Capability.RESTORING

    def __init__(self, layout: KnotLayout, weights: FloatArray, start_times: FloatArray) -> None:
        """`weights` K^R (A,), `start_times` t_0 (A,) in s."""
        self._layout = layout
        self._start = layout.segment
        self._agent = layout.agent_of_segment
        self._last = layout.last
        self._weight = weights / layout.num_segments
        self._start_times = start_times

    @classmethod
    def build(cls, setup: TermSetup) -> Regularity:
        """Every scene has it."""
        formulation = setup.formulation
        weights, starts = formulation.scales.regularity, formulation.problem.start_times
        return cls(formulation.layout, weights, starts)

    def _durations(self, knots: FloatArray) -> tuple[FloatArray, FloatArray]:
        step = knots[self._start + 1, 2] - knots[self._start, 2]
        return step, knots[self._last, 2] - self._start_times

    def value(self, knots: FloatArray) -> float:
        """The cost, inf where time does not advance."""
        return float(self.per_agent(knots).sum())

    def per_agent(self, knots: FloatArray) -> FloatArray:
        """The cost of every agent (A,)."""
        step, total = self._durations(knots)
        if not (step > 0).all():
            return np.full(self._layout.num_agents, np.inf)
        return self._weight * total * np.bincount(self._agent, 1 / step, len(total))

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3); only times matter."""
        step, total = self._durations(knots)
        push = -(self._weight * total)[self._agent] / step**2
        result = np.zeros_like(knots)
        result[self._start + 1, 2] += push
        result[self._start, 2] -= push
        result[self._last, 2] += self._weight * np.bincount(self._agent, 1 / step, len(total))
        return result

    def hessian_structure(self) -> Structure:
        """(t_i, t_i), (t_{i+1}, t_{i+1}), (t_{i+1}, t_i), then the arrow (t_n, t_i), (t_n, t_{i+1})."""
        rows, columns = self.gauss_newton_structure()
        last = 3 * self._last[self._agent] + 2
        ends = [3 * self._start + 2, 3 * self._start + 5]
        return np.concatenate([rows, last, last]), np.concatenate([columns, *ends])

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of the structure."""
        step, _ = self._durations(knots)
        arrow = self._weight[self._agent] / step**2
        # On the last segment the arrow's second entry lies on the diagonal and counts twice.
        twice = np.where(self._start + 1 == self._last[self._agent], 2.0, 1.0)
        return np.concatenate([self.gauss_newton_hessian(knots), arrow, -twice * arrow])

    def gauss_newton_structure(self) -> Structure:
        """(t_i, t_i), (t_{i+1}, t_{i+1}) and (t_{i+1}, t_i)."""
        first, second = 3 * self._start + 2, 3 * self._start + 5
        return np.concatenate([first, second, second]), np.concatenate([first, second, first])

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The diagonal of the durations alone."""
        step, total = self._durations(knots)
        stiff = 2 * (self._weight * total)[self._agent] / step**3
        return np.concatenate([stiff, stiff, -stiff])
