"""Figures that tell how good curves are, computed apart from the optimiser's costs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from stplan.analysis.paths import segment_lengths
from stplan.arrays import FloatArray
from stplan.problem.kinetic_cost import kinetic_cost, least_kinetic_cost
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
        return asdict(self)


def straight_bound(agent: Agent) -> float:
    """Least kinetic cost of an agent alone in the open plane: straight (by waypoints), in J s."""
    stops = np.array([agent.start, *agent.waypoints, agent.goal])
    return least_kinetic_cost(agent.mass, stops, agent.max_time - agent.start_time)


def turning(curve: FloatArray, time_scale: float) -> float:
    """sum 1/2 theta^2 of the turns of a curve in (x, y, c t), in square radians."""
    step = np.diff(curve * [1.0, 1.0, time_scale], axis=0)
    u, v = step[:-1], step[1:]
    sine = np.sqrt((np.cross(u, v) ** 2).sum(axis=1))
    return float(0.5 * (np.arctan2(sine, (u * v).sum(axis=1)) ** 2).sum())


def metrics(scene: Scene, lines: WorldLines) -> Metrics:
    """Figures of `lines` in scene order."""
    agents = []
    energy = bound = 0.0
    for agent, curve in zip(scene.agents, lines.curves(), strict=True):
        lengths = segment_lengths(curve)
        own = kinetic_cost(agent.mass, curve)
        if agent.path is None:
            energy += agent.weights.kinetic * own
            bound += agent.weights.kinetic * straight_bound(agent)
        agents.append(
            AgentMetrics(
                agent=agent.id,
                arrival_time=float(curve[-1, 2]),
                path_length=float(lengths.sum()),
                greatest_speed=float((lengths / np.diff(curve[:, 2])).max()),
                kinetic_energy=own,
                turning=turning(curve, scene.turning_scale),
            )
        )
    return Metrics(
        kinetic_over_straight=energy / bound if bound > 0 else None,
        turning=float(sum(one.turning for one in agents)),
        latest_arrival=max(one.arrival_time for one in agents),
        agents=tuple(agents),
    )
