"""Haste: C^H_a = W_a (D / p) ((t_n - r_a) / D)^p, felt where arrivals are to be early.

With p = 1 and r_a the agent's start the sum of the arrival times is least; with r the earliest start, D the
time from there to the latest arrival and p large, the latest arrival: whose price per second is W_a, that of
half as late ones 2^(p - 1) times less. W_a = EAGERNESS m_a v_a^2 with v_a the top speed: a second is worth so
much more than the energy of hurrying, m v^2 / 2 a second, that agents move as fast as they may.

Derivatives in t_n, with u = (t_n - r_a) / D:  W u^(p - 1)  and  W (p - 1) / D u^(p - 2).
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem

# A second over m v^2, and p where the latest arrival counts.
EAGERNESS, LATEST_POWER = 30.0, 8.0


@register(rank=45)
class Haste(Term):
    """Cost of arriving, the dearer the later."""

    name = "haste"
    capabilities = Capability.PRICE

    def __init__(
        self,
        layout: KnotLayout,
        weights: FloatArray,
        origins: FloatArray,
        span: float,
        power: float,
    ) -> None:
        """`weights` W (A,), `origins` r (A,) in s, `span` D in s, `power` p >= 1."""
        self._last = layout.last
        self._weights, self._origins = weights, origins
        self._span, self._power = span, power

    @classmethod
    def build(cls, setup: TermSetup) -> Haste | None:
        """Where the scene minimises arrivals."""
        formulation = setup.formulation
        return haste(formulation.problem, formulation.layout, formulation.scales.span)

    def value(self, knots: FloatArray) -> float:
        """The cost in seconds times weight."""
        return float(self.per_agent(knots).sum())

    def per_agent(self, knots: FloatArray) -> FloatArray:
        """The cost of every agent (A,)."""
        return self._weights * self._span / self._power * self._late(knots) ** self._power

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        result = np.zeros_like(knots)
        result[self._last, 2] = self._weights * self._late(knots) ** (self._power - 1.0)
        return result

    def hessian_structure(self) -> Structure:
        """One entry an agent: (t_n, t_n)."""
        return 3 * self._last + 2, 3 * self._last + 2

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Zero where p = 1."""
        if self._power == 1.0:
            return np.zeros_like(self._weights)
        curvature = (self._power - 1.0) / self._span * self._late(knots) ** (self._power - 2.0)
        return np.asarray(self._weights * curvature)

    def gauss_newton_structure(self) -> Structure:
        """That of the Hessian."""
        return self.hessian_structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The exact one, which is positive semidefinite."""
        return self.hessian(knots)

    def _late(self, knots: FloatArray) -> FloatArray:
        """u (A,), at least 0."""
        return np.asarray(np.maximum(knots[self._last, 2] - self._origins, 0.0) / self._span)


def haste(problem: PlanningProblem, layout: KnotLayout, span: float) -> Haste | None:
    """The term of `problem`, whose latest arrival is `span` s after the earliest start; None for energy."""
    objective = problem.scene.minimise
    if objective == "energy":
        return None
    weights = np.array(
        [
            0.0 if agent.path is not None or agent.max_speed is None
            else EAGERNESS * agent.mass * agent.max_speed**2
            for agent in problem.scene.agents
        ]
    )  # fmt: skip
    if objective == "arrivals":
        return Haste(layout, weights, problem.start_times, span, 1.0)
    origins = np.full(len(weights), problem.start_times.min())
    return Haste(layout, weights, origins, span, LATEST_POWER)


def arrival_span(problem: PlanningProblem, arrivals: FloatArray) -> float:
    """From the earliest start to the latest of the `arrivals` (A,) of those who find their way, s."""
    movers = ~problem.prescribed
    latest = float(arrivals[movers].max()) if movers.any() else 0.0
    return max(latest - float(problem.start_times.min()), 1e-300)
