"""Prioritised planning by cost: one agent after another, each on its cheapest way around those before it.

Safe-interval search sends everybody to its goal as early as possible, which leaves dear detours and queues
behind. Here every agent takes the way that costs it least among the rods already there. Either a move costs
what it costs in the plan, |dx|^2 / (2 dt), so that everybody is as slow as its time allows; or its length in
space-time, the paper's choice, which prefers short ways. Scenes that suit one of them often defeat the
other. The agent that found no way goes first in the next order, until everyone has been first; then orders
are random.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.requirement import Requirement, requirement
from stplan.problem.verification import verify
from stplan.reasons import Reason
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.layered_dijkstra import HARD, space_time_length
from stplan.seeding.search.levels import Level, Levels, off_roadmap, out_of_layers
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.search.prioritized import GUARD_LAYERS
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord

# Orders tried from one random number: another one is worth more than to go on.
ORDERS = 6
# So many starts of both costs over the number of agents, or over that of agents, moves and layers; of
# either cost at least, at most.
STARTED_AGENTS, STARTED_WORK = 100, 10**8
FEWEST_STARTS, MOST_STARTS = 2, 4
# Starts of more work take many seconds each, mostly in vain: none are made.
MOST_WORK = 3 * 10**8
# Margins tried; smaller ones are left to other searches.
MARGINS = 2
# Standing still costs this share of the dearest move, so that nobody wanders where it may as well wait.
IDLE_SHARE = 1e-3


@dataclass(frozen=True)
class LeastCost:
    """Clear curves, each the cheapest around those planned before it.

    Attributes:
        by_length: whether a move costs its length in space-time, else what moving costs.
    """

    name: ClassVar = "least-cost"
    levels: Levels
    by_length: bool = False

    @property
    def worthwhile_starts(self) -> int:
        """How many starts of either cost a scene is worth: fewer of more agents and of larger roadmaps."""
        problem = self.levels.problem
        level = self.levels.at(problem.scene.seeding.margin)
        work = problem.num_agents * len(level.graph.length) * level.layers
        if work > MOST_WORK:
            return 0
        worth = min(STARTED_AGENTS // (2 * problem.num_agents), STARTED_WORK // (2 * work))
        return min(max(worth, FEWEST_STARTS), MOST_STARTS)

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Orders for ever smaller margins, until one succeeds; all on one roadmap."""
        problem, level = self.levels.problem, self._level()
        if level is None:
            first = self.levels.at(problem.scene.seeding.margin)
            return SeedAttempt(f"search ({self.name})", reasons=off_roadmap(first))
        reasons: tuple[Reason, ...] = ()
        tries = 0
        for number, margin in enumerate(margin_ladder(level.margin)[:MARGINS]):
            if budget.spent():
                break
            planner = level.planner(1, self._required(level, margin))
            if planner.too_late():
                reasons = out_of_layers(planner)
                break
            rng = np.random.default_rng([budget.rng_seed, number])
            cost = (
                space_time_length(planner.graph, planner.grid.height)
                if self.by_length
                else move_costs(planner)
            )
            curves, tried = _plan_orders(planner, cost, rng, budget)
            tries += tried
            if curves is not None and not verify(problem, curves, planner.required):
                record = SeedRecord(margin=margin, tries=tries)
                return SeedAttempt(f"search ({self.name})", curves, clear=True, record=record)
        return SeedAttempt(f"search ({self.name})", record=SeedRecord(tries=tries), reasons=reasons)

    def _level(self) -> Level | None:
        """The widest margin whose roadmap connects everybody, None where there is none."""
        levels = map(self.levels.at, margin_ladder(self.levels.problem.scene.seeding.margin))
        return next((level for level in levels if not level.journeys.stranded()), None)

    def _required(self, level: Level, margin: float) -> Requirement | None:
        """What a smaller margin asks between agents; a roadmap of its own would not be worth its time."""
        if margin == level.margin:
            return None
        return Requirement(requirement(self.levels.problem, margin).rods, level.required.walls)


def _plan_orders(
    planner: LayeredPlanner, cost: FloatArray, rng: np.random.Generator, budget: Budget
) -> tuple[list[FloatArray] | None, int]:
    """Curves from the first order that gives any, and how many orders were tried.

    Random number 0 begins with the order of longest ways, all others with a random one.
    """
    movers = planner.movers
    order = [int(agent) for agent in rng.permutation(movers)]
    if budget.rng_seed == 0:
        order.sort(key=lambda agent: -int(planner.journeys.distance[agent]))
    bumps = 0
    for attempt in range(ORDERS):
        if budget.spent():
            return None, attempt
        curves, failed = _plan_order(planner, order, cost, GUARD_LAYERS if attempt % 3 != 2 else 0)
        if curves is not None:
            return curves, attempt + 1
        if bumps < len(movers) and order[0] != failed:
            order.remove(failed)
            order.insert(0, failed)
            bumps += 1
        else:
            order = [int(agent) for agent in rng.permutation(movers)]
            bumps = 0
    return None, ORDERS


def move_costs(planner: LayeredPlanner) -> FloatArray:
    """(M,) kinetic cost of every move for a mass of 1, and a little for each layer that passes; J s."""
    cost = planner.graph.length**2 / (2.0 * planner.grid.step)
    return np.asarray(cost + IDLE_SHARE * cost.max())


def _plan_order(
    planner: LayeredPlanner, order: list[int], cost: FloatArray, guard_layers: int
) -> tuple[list[FloatArray] | None, int]:
    """Curves of all agents planned in `order` and -1, or None and the agent that found no way."""
    planner.reset()
    curves = [path if path is not None else np.empty((0, 3)) for path in planner.problem.paths]
    guards = {agent: planner.guard(agent, guard_layers) for agent in order if guard_layers}
    for blocks in guards.values():
        planner.add(blocks)
    for agent in order:
        if agent in guards:
            planner.remove(guards[agent])
        path = planner.cheapest_path(agent, cost, HARD)
        if path is None:
            return None, agent
        curves[agent] = planner.curve(agent, path)
        planner.add(planner.blocks(agent, curves[agent]))
    return curves, -1
