"""What agents pay on a plan: all of its costs but barriers and regularity, which only shape the way to it."""

from __future__ import annotations

import numpy as np

from stplan.analysis.metrics import turning
from stplan.arrays import FloatArray
from stplan.costs.contacts.nearest_candidates import NearestCandidates
from stplan.costs.contacts.smooth_minimum import smooth_minimum
from stplan.geometry.contacts import measure
from stplan.problem.kinetic_cost import kinetic_cost
from stplan.problem.layout import KnotLayout
from stplan.problem.rods import Rods
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import Agent, Scene


def own_costs(scene: Scene, lines: WorldLines) -> FloatArray:
    """(A,) kinetic, acceleration and arrival cost of every agent, and half of its pairs' grouping cost."""
    alone = np.array(
        [
            _own_cost(agent, curve, scene.turning_scale)
            for agent, curve in zip(scene.agents, lines.curves(), strict=True)
        ]
    )
    if not any(rule.grouping for rule in scene.pairs):
        return alone
    return alone + _grouping_costs(scene, lines)


def _own_cost(agent: Agent, curve: FloatArray, turning_scale: float) -> float:
    weights = agent.weights
    cost = weights.kinetic * kinetic_cost(agent.mass, curve)
    if weights.acceleration:
        cost += weights.acceleration * turning(curve, turning_scale)
    if agent.preferred_time is not None:
        cost += weights.arrival * 0.5 * (float(curve[-1, 2]) - agent.preferred_time) ** 2
    return cost


def _grouping_costs(scene: Scene, lines: WorldLines) -> FloatArray:
    """(A,) the cost of every grouped pair, as the grouping term has it, in halves to both."""
    interactions, alpha = scene_interactions(scene), scene.solver.alpha
    pairs = np.column_stack(np.nonzero(np.triu(interactions.grouping)))
    layout, count = KnotLayout.from_offsets(lines.offsets), len(scene.agents)
    rods = Rods.build(layout, lines.knots, np.empty(0, np.int64), 0.0, scene.time_scale)
    friends = NearestCandidates(rods, pairs, count, np.full(len(pairs), alpha), tails=False)
    contacts = friends.find(lines.knots, 0.0)
    distance = measure(friends.positions(lines.knots), contacts.points).distance
    costs = np.zeros(count)
    for g, key in enumerate(contacts.keys.tolist()):
        pair = divmod(key, count)
        apart = smooth_minimum(distance[contacts.starts[g] : contacts.starts[g + 1]], alpha)
        weight = interactions.grouping[pair]
        costs[list(pair)] += 0.5 * weight * (apart - interactions.distance[pair]) ** 2
    return costs
