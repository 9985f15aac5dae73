"""What single agents pay on a plan: the costs that do not depend on how the others are weighed."""

from __future__ import annotations

import numpy as np

from stplan.analysis.metrics import turning
from stplan.arrays import FloatArray
from stplan.problem.kinetic_cost import kinetic_cost
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene


def own_costs(scene: Scene, lines: WorldLines) -> FloatArray:
    """(A,) kinetic, acceleration and arrival cost of every agent, weighted."""
    return np.array(
        [
            _own_cost(agent, curve, scene.time_scale)
            for agent, curve in zip(scene.agents, lines.curves(), strict=True)
        ]
    )


def _own_cost(agent: Agent, curve: FloatArray, time_scale: float) -> float:
    weights = agent.weights
    cost = weights.kinetic * kinetic_cost(agent.mass, curve)
    if weights.acceleration:
        cost += weights.acceleration * turning(curve, time_scale)
    if agent.preferred_time is not None:
        cost += weights.arrival * 0.5 * (float(curve[-1, 2]) - agent.preferred_time) ** 2
    return cost
