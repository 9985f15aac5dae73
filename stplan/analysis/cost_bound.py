"""What plans cannot cost less than: every agent's least cost if nobody else were there.

A plan costs what its agents pay by themselves (kinetic, turning and arrival cost). Each pays at least what it
would pay alone, and alone at least the following (docs/method.md has the proof). Its way is no shorter than
the lengths L_k of `shortest_legs` between its stops, and takes the time that is left of D = t_n - t_0 when
it has dwelt; so by Cauchy and Schwarz

    kinetic cost >= K^K m (sum_k L_k)^2 / (2 (D - sum of dwells)),

and with the arrival cost K^T (t_0 + D - T^p)^2 / 2 the least over all D that limits, windows and T^max
leave is a minimum of a convex function of one variable. Between two visits with windows no more time passes
than from the begin of one to the end of the other, which bounds parts of the way apart. Turning costs at
least nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.analysis.joint_bounds import Together, joint_bounds
from stplan.analysis.own_costs import own_costs
from stplan.analysis.shortest_trips import shortest_duration, shortest_legs
from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene, Visit

# Share by which bounds are made smaller, against rounding here and in what a certificate lets pass.
ROUNDING = 1e-8
# Halvings of the interval that the best duration lies in.
HALVINGS = 100


@dataclass(frozen=True)
class CostBound:
    """What agents pay on a plan, and at least on any other.

    Attributes:
        agents: their names.
        costs, least: (A,) J s; the least is what each would pay alone.
        together: what groups of them pay at least beyond that.
    """

    agents: tuple[str, ...]
    costs: FloatArray
    least: FloatArray
    together: tuple[Together, ...] = ()

    @property
    def cost(self) -> float:
        """What all pay, J s."""
        return float(self.costs.sum())

    @property
    def total(self) -> float:
        """What all pay at least, J s."""
        return float(self.least.sum()) + sum(group.extra for group in self.together)

    @property
    def excess(self) -> float | None:
        """Share by which the plan can be dearer than the best one; None where that may cost nothing."""
        return max(self.cost / self.total - 1.0, 0.0) if self.total > 0.0 else None

    @property
    def sentence(self) -> str:
        """How good the plan is at least, in words."""
        if self.excess is None:
            return f"cost {self.cost:.4g}"
        percent = 100.0 * self.excess
        return f"cost {self.cost:.4g}, at most {percent:.3g} % above any plan's"

    def as_dict(self) -> dict[str, Any]:
        """For the report."""
        return {
            "cost": self.cost,
            "least": self.total,
            "excess": self.excess,
            "agents": [
                {"agent": name, "cost": float(cost), "least": float(least)}
                for name, cost, least in zip(self.agents, self.costs, self.least, strict=True)
            ],
            "together": [group.as_dict(self.agents) for group in self.together],
        }


def cost_bound(problem: PlanningProblem, lines: WorldLines) -> CostBound:
    """What the agents of `lines`, a plan of `problem` as the user's in scene order, pay and have to pay."""
    legs = shortest_legs(problem)
    least = _least_alone(problem, legs)
    together = joint_bounds(problem, legs, least)
    return bound_with(problem.written.scene, lines, problem.frame.cost * least, together)


def bound_with(
    scene: Scene, lines: WorldLines, least: FloatArray, together: tuple[Together, ...]
) -> CostBound:
    """The same with what is already known to be the least."""
    costs = own_costs(scene, lines)
    # Prescribed motion costs what it costs.
    given = np.array([agent.path is not None for agent in scene.agents])
    least = np.where(given, (1.0 - ROUNDING) * costs, least)
    return CostBound(lines.agent_ids, costs, least, together)


def least_costs(problem: PlanningProblem) -> FloatArray:
    """(A,) what every agent that plans its motion pays at least on any plan; 0 for the others."""
    return _least_alone(problem, shortest_legs(problem))


def _least_alone(problem: PlanningProblem, legs: Sequence[FloatArray]) -> FloatArray:
    return np.array(
        [
            0.0 if agent.path is not None else (1.0 - ROUNDING) * _least_cost(agent, own)
            for agent, own in zip(problem.scene.agents, legs, strict=True)
        ]
    )


def _least_cost(agent: Agent, legs: FloatArray) -> float:
    """Of an agent whose ways between stops are no shorter than `legs` (w + 1,), m."""
    visits = agent.visits or (Visit(),) * len(agent.waypoints)
    stiffness = 0.5 * agent.weights.kinetic * agent.mass
    dwelt = sum(visit.dwell for visit in visits)
    length = float(legs.sum())
    shortest = max(shortest_duration(agent, legs), dwelt)
    longest = max(agent.max_time - agent.start_time, shortest)
    aim, weight = agent.preferred_time, agent.weights.arrival
    if aim is None or weight <= 0.0:
        whole = _kinetic(stiffness, length, longest - dwelt)
        return max(whole, _within_windows(agent, legs, visits, stiffness))
    early = _cheapest(
        stiffness * length**2, weight, aim - agent.start_time, dwelt, shortest, longest
    )
    late = 0.5 * weight * max(agent.start_time + shortest - aim, 0.0) ** 2
    return max(early, late + _within_windows(agent, legs, visits, stiffness))


def _kinetic(stiffness: float, length: float, duration: float) -> float:
    """Least kinetic cost of a way of so many m in so many s; 0 where there is no time for rounding."""
    return stiffness * length**2 / duration if duration > 0.0 else 0.0


def _cheapest(
    work: float, weight: float, aim: float, dwelt: float, shortest: float, longest: float
) -> float:
    """Minimum over D in [shortest, longest] of work / (D - dwelt) + weight / 2 (D - aim)^2, convex in D."""

    def cost(duration: float) -> float:
        moving = duration - dwelt
        kinetic = work / moving if moving > 0.0 else np.inf if work > 0.0 else 0.0
        return float(kinetic + 0.5 * weight * (duration - aim) ** 2)

    def falls(duration: float) -> bool:
        moving = duration - dwelt
        return moving <= 0.0 or weight * (duration - aim) * moving**2 < work

    low, high = shortest, longest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if falls(middle) else (low, middle)
    return min(cost(low), cost(high))


def _within_windows(
    agent: Agent, legs: FloatArray, visits: Sequence[Visit], stiffness: float
) -> float:
    """Kinetic cost at least of the parts of the way between windows, whichever of them bind.

    best[j] is that of everything before the visit of anchor j; the parts between anchors use up different
    times, so their bounds add up, and every choice of anchors is a bound.
    """
    last = len(visits) + 1
    anchors = [0, *(k + 1 for k, visit in enumerate(visits) if visit.window is not None), last]
    dwells = [0.0, *(visit.dwell for visit in visits), 0.0]
    begins = [agent.start_time, *(_window(visit)[0] for visit in visits), agent.max_time]
    ends = [agent.start_time, *(_window(visit)[1] for visit in visits), agent.max_time]
    best = {0: 0.0}
    for j in anchors[1:]:
        options = []
        for i in (anchor for anchor in anchors if anchor < j):
            begin = begins[i] + (dwells[i] if i else 0.0)
            moving = ends[j] - dwells[j] - begin - sum(dwells[i + 1 : j])
            options.append(best[i] + _kinetic(stiffness, float(legs[i:j].sum()), moving))
        best[j] = max(options)
    return best[last]


def _window(visit: Visit) -> tuple[float, float]:
    return visit.window or (-np.inf, np.inf)
