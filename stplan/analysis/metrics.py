"""Figures that tell how good curves are, computed apart from the optimiser's costs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.kinetic_cost import least_kinetic_cost
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene


@dataclass(frozen=True)
class AgentMetrics:
    """Figures of one agent: s, m, m/s, J s, and square radians."""

    agent: str
    arrival_time: float
    path_length: float
    greatest_speed: float
    kinetic_energy: float
    turning: float


@dataclass(frozen=True)
class Metrics:
    """Figures of a whole plan.

    Attributes:
        kinetic_over_straight: kinetic cost of all that find their way over its least, with their
            weights; None where that is 0.
        turning: of all agents together, in square radians.
        latest_arrival: s.
        agents: in scene order.
    """

    kinetic_over_straight: float | None
    turning: float
    latest_arrival: float
    agents: tuple[AgentMetrics, ...]

    def as_dict(self) -> dict[str, Any]:
        """For the report."""
        return {**vars(self), "agents": [dict(vars(one)) for one in self.agents]}


def straight_bound(agent: Agent) -> float:
    """Least kinetic cost of an agent alone in the open plane: straight (by waypoints), in J s."""
    stops = np.array([agent.start, *agent.waypoints, agent.goal])
    return least_kinetic_cost(agent.mass, stops, agent.max_time - agent.start_time)


def turning(curve: FloatArray, time_scale: float) -> float:
    """sum 1/2 theta^2 of the turns of a curve in (x, y, c t), in square radians."""
    return float(0.5 * _squared_turns(curve, time_scale).sum())


def _squared_turns(knots: FloatArray, time_scale: float) -> FloatArray:
    """(n - 2,) theta^2 between the segments before and after every knot (n, 3) but the ends."""
    step = np.diff(knots * [1.0, 1.0, time_scale], axis=0)
    u, v = step[:-1], step[1:]
    sine = np.sqrt((np.cross(u, v) ** 2).sum(axis=1))
    angles: FloatArray = np.arctan2(sine, (u * v).sum(axis=1))
    return angles**2


def metrics(scene: Scene, lines: WorldLines) -> Metrics:
    """Figures of `lines` in scene order."""
    # What is between the curves of two agents belongs to neither.
    step = np.diff(lines.knots, axis=0)
    lengths = np.hypot(step[:, 0], step[:, 1])
    masses = np.repeat([agent.mass for agent in scene.agents], np.diff(lines.offsets))[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        speeds = lengths / step[:, 2]
        kinetic = 0.5 * masses * (step[:, :2] ** 2).sum(axis=1) / step[:, 2]
    turns = _squared_turns(lines.knots, scene.turning_scale)
    agents = []
    energy = bound = 0.0
    for agent, (first, past) in zip(scene.agents, pairwise(lines.offsets.tolist()), strict=True):
        own = float(kinetic[first : past - 1].sum())
        if agent.path is None:
            energy += agent.weights.kinetic * own
            bound += agent.weights.kinetic * straight_bound(agent)
        agents.append(
            AgentMetrics(
                agent=agent.id,
                arrival_time=float(lines.knots[past - 1, 2]),
                path_length=float(lengths[first : past - 1].sum()),
                greatest_speed=float(speeds[first : past - 1].max()),
                kinetic_energy=own,
                turning=float(0.5 * turns[first : past - 2].sum()),
            )
        )
    return Metrics(
        kinetic_over_straight=energy / bound if bound > 0 else None,
        turning=float(sum(one.turning for one in agents)),
        latest_arrival=max(one.arrival_time for one in agents),
        agents=tuple(agents),
    )
