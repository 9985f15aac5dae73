"""Arrival cost: C^T_a = K^T_a 1/2 (t_n - T^p_a)^2   (the paper's preferred end time equation)."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import Formulation, TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout


@register(rank=40)
class Arrival(Term):
    """Quadratic cost of arriving before or after the preferred time."""

    name = "arrival"
    capabilities = Capability.PRICE | Capability.RESTORING

    def __init__(self, layout: KnotLayout, weights: FloatArray, preferred: FloatArray) -> None:
        """`weights` K^T (A,), `preferred` T^p (A,) in s (any finite number where the weight is 0)."""
        self._last = layout.last
        self._weights = weights
        self._preferred = preferred

    @classmethod
    def build(cls, setup: TermSetup) -> Arrival | None:
        """Where an agent has `weights.arrival`."""
        formulation = setup.formulation
        weights = formulation.weights("arrival")
        if not weights.any():
            return None
        layout, problem = formulation.layout, formulation.problem
        if setup.penalties is not None:
            return cls(layout, _restoring(formulation, weights), problem.preferred_times)
        preferred = [agent.preferred_time or 0.0 for agent in problem.scene.agents]
        return cls(layout, weights, np.array(preferred))

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

    def hessian_structure(self) -> Structure:
        """One entry an agent: (t_n, t_n)."""
        return 3 * self._last + 2, 3 * self._last + 2

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Constant weights."""
        return self._weights.copy()

    def gauss_newton_structure(self) -> Structure:
        """That of the Hessian."""
        return self.hessian_structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The exact one, which is positive semidefinite."""
        return self.hessian(knots)


def _restoring(formulation: Formulation, weights: FloatArray) -> FloatArray:
    """(A,) weights that hold agents near their free arrivals without being dearer than their motion.

    While limits are missed nobody can be on time, and a dear wish for it would win against them; but without
    any an agent would slow down without end, because slow is cheap.
    """
    problem = formulation.problem
    span = problem.preferred_times - problem.start_times
    return np.minimum(weights, formulation.scales.own / span**2)
