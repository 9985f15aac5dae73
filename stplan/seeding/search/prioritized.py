"""Prioritised planning with restarts: one agent after another, each around those before it.

No order of priorities solves a symmetric swap in a pocket when everybody arrives as early as
possible; holding random agents at their starts for a while does. The agent that found no way goes
first in the next order, until everyone has been first; then orders are random.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.callbacks import Stop, never
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.seeder import SeedAttempt

NAME = "prioritized"

# Starts of agents not yet planned stay reserved for so many layers, in two tries of three.
GUARD_LAYERS = 2


def plan_in_order(
    planner: LayeredPlanner,
    order: Sequence[int],
    holds: IntArray,
    guard_layers: int = GUARD_LAYERS,
    stopped: Stop = never,
) -> tuple[list[FloatArray] | None, int]:
    """Curves of all agents planned in `order` and -1, or None and the agent that found no way.

    `holds` (A,): layers every agent is held at its start. Once `stopped`, nobody finds one.
    """
    planner.reset()
    curves = [path if path is not None else np.empty((0, 3)) for path in planner.problem.paths]
    guards = {}
    if guard_layers > 0:
        guards = {agent: planner.guard(agent, guard_layers) for agent in order}
        for blocks in guards.values():
            planner.add(blocks)
    for place, agent in enumerate(order):
        if guard_layers > 0:
            planner.remove(guards[agent])
        path = None if stopped() else planner.path(agent, int(holds[agent]))
        if path is None:
            return None, agent
        curves[agent] = planner.curve(agent, path)
        if place + 1 < len(order):
            planner.add(planner.blocks(agent, curves[agent]))
    return curves, -1


def random_holds(
    planner: LayeredPlanner, rng: np.random.Generator, most_held: int, part: float = 0.5
) -> IntArray:
    """(A,) random holds of up to `most_held` agents, at most `part` of their slack each."""
    holds = np.zeros(planner.problem.num_agents, dtype=np.int64)
    count = int(rng.integers(1, max(most_held, 1) + 1))
    held = rng.choice(planner.movers, size=min(count, len(planner.movers)), replace=False)
    for agent in held:
        holds[agent] = rng.integers(0, max(2, int(planner.slack[agent] * part) + 1))
    return holds


def plan_prioritized(
    planner: LayeredPlanner,
    rng: np.random.Generator,
    max_tries: int,
    stopped: Stop,
) -> SeedAttempt:
    """Try up to `max_tries` orders, longest ways first, then bumped, random and held ones."""
    movers = planner.movers
    order = sorted(movers, key=lambda agent: -int(planner.journeys.distance[agent]))
    bumps = 0
    for attempt in range(max_tries):
        if attempt > 0 and stopped():
            return SeedAttempt(NAME).counting(attempt)
        holds = np.zeros(planner.problem.num_agents, dtype=np.int64)
        if attempt > min(2 * len(movers), 12) and rng.random() < 0.6:
            holds = random_holds(planner, rng, max(1, len(movers) // 3))
        guard = GUARD_LAYERS if attempt % 3 != 2 else 0
        curves, failed = plan_in_order(planner, order, holds, guard, stopped)
        if curves is not None:
            return SeedAttempt(NAME, curves, clear=True).counting(attempt + 1)
        if bumps < len(movers) and order[0] != failed:
            order.remove(failed)
            order.insert(0, failed)
            bumps += 1
        else:
            order = [int(agent) for agent in rng.permutation(movers)]
            bumps = 0
    return SeedAttempt(NAME).counting(max_tries)
