"""Arrival cost: C^T_a = K^T_a 1/2 (t_n - T^p_a)^2   (the paper's preferred end time equation)."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.term import Term
from stplan.problem.layout import KnotLayout


class Arrival(Term):
    """Quadratic cost of arriving before or after the preferred time."""

    name = "arrival"

    def __init__(self, layout: KnotLayout, weights: FloatArray, preferred: FloatArray) -> None:
        """`weights` K^T (A,), `preferred` T^p (A,) in s (any finite number where the weight is 0)."""
        self._last = layout.last
        self._weights = weights
        self._preferred = preferred

    def value(self, knots: FloatArray) -> float:
        """The cost in square seconds times weight."""
        return float(self.per_agent(knots).sum())

    def per_agent(self, knots: FloatArray) -> FloatArray:
        """The cost of every agent (A,)."""
        return 0.5 * self._weights * (knots[self._last, 2] - self._preferred) ** 2

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        result = np.zeros_like(knots)
        result[self._last, 2] = self._weights * (knots[self._last, 2] - self._preferred)
        return result

    def hessian_structure(self) -> tuple[IntArray, IntArray]:
        """One entry an agent: (t_n, t_n)."""
        return 3 * self._last + 2, 3 * self._last + 2

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Constant weights."""
        return self._weights.copy()
