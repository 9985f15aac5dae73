"""What every agent pays by itself, as the terms of the objective have it: the scale it is judged on."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.terms.acceleration import Acceleration
from stplan.costs.terms.arrival import Arrival
from stplan.costs.terms.haste import Haste, haste
from stplan.costs.terms.kinetic import Kinetic
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem


class Payments:
    """Kinetic, acceleration, arrival and haste costs of single agents."""

    def __init__(self, problem: PlanningProblem, layout: KnotLayout, span: float) -> None:
        """`span` as in `Scales`."""
        agents = problem.scene.agents
        kinetic = np.array([agent.weights.kinetic for agent in agents])
        turning = np.array([agent.weights.acceleration for agent in agents])
        late = np.array([agent.weights.arrival for agent in agents])
        preferred = np.array([agent.preferred_time or 0.0 for agent in agents])
        self._terms: list[Kinetic | Acceleration | Arrival | Haste] = [
            Kinetic(layout, kinetic, problem.masses)
        ]
        if turning.any():
            self._terms.append(Acceleration(layout, turning, problem.time_scale))
        if late.any():
            self._terms.append(Arrival(layout, late, preferred))
        hastening = haste(problem, layout, span)
        if hastening is not None:
            self._terms.append(hastening)
        # Whether it matters to an agent when it arrives.
        self.punctual = ((late > 0) | (hastening is not None)) & ~problem.prescribed

    def paid(self, knots: FloatArray) -> FloatArray:
        """(A,) at knots (M, 3)."""
        total: FloatArray = np.sum([term.per_agent(knots) for term in self._terms], axis=0)
        return total
