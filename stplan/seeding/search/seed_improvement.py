"""Large-neighbourhood search on clear seeds: cheaper homotopy classes at a hundred tries a second.

A state is one clear curve an agent, all of them reserved. A move frees a few agents, of which the first is
drawn by what its curve costs beyond its own shortest way and the others by how near their rods come, and
replans them in random order among all others: mostly on the cheapest way, with costs a little random, else
as early as possible after a hold. A state is worth what it costs once shortened; the optimiser is not asked.
Cheaper states are accepted, and now and then one that is a little dearer. The cheapest states of different
classes are given back, as shortened.

Moves are counted, so the clock only decides whether all of them are made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.deadline import heed
from stplan.problem.kinetic_cost import kinetic_cost, total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, held_requirement
from stplan.problem.verification import verify
from stplan.seeding.homotopy import signature
from stplan.seeding.margins import SMALLER_MARGINS
from stplan.seeding.search.conflicts import CurveSet
from stplan.seeding.search.layered_dijkstra import HARD, space_time_length
from stplan.seeding.search.least_cost import LeastCost, move_costs
from stplan.seeding.search.levels import Level, Levels
from stplan.seeding.search.planner import Blocks, LayeredPlanner
from stplan.seeding.seeder import Budget, SeedAttempt
from stplan.seeding.shortcutting.shortcuts import take_shortcuts

# Agents freed at once, at most, and how near a neighbour's rod comes, in required distances.
LARGEST_NEIGHBOURHOOD = 8
NEIGHBOURS = 12
NEARBY = 6.0
# An agent takes its cheapest way with this probability, else the earliest one after a hold.
CHEAPEST = 0.6
# Costs of moves are random within this share, so that ways differ from try to try.
NOISE = 0.2
# A state dearer by this share is accepted with probability 1/e.
TEMPERATURE = 0.003
# Rounds of shortcuts that say what a state is worth.
ROUNDS = 3
# States remembered, the cheapest ones.
REMEMBERED = 200
# Pairs that hold less than so many times R count as touching.
LEAST_HELD = 1.0005

# What an improvement may take: moves times the size of the layered roadmap and of the crowd, in numbers of
# labels; about a second. An agent weighs so many labels, by what it takes to shorten its curve.
IMPROVEMENT_WORK, AGENT_WORK = 8 * 10**7, 3 * 10**4
# Few agents have few classes.
MOST_MOVES, MOVES_AN_AGENT = 240, 24


def worthwhile_moves(levels: Levels) -> int:
    """How many moves a scene is worth: fewer of more agents and of larger roadmaps."""
    most = min(MOST_MOVES, MOVES_AN_AGENT * levels.problem.num_agents)
    return min(moves_in_a_second(levels), most)


def moves_in_a_second(levels: Levels) -> int:
    """How many moves take about a second: fewer of more agents and of larger roadmaps."""
    level = levels.at(_margin(levels))
    work = len(level.graph.length) * level.layers + AGENT_WORK * levels.problem.num_agents
    return IMPROVEMENT_WORK // work


def improve_seed(
    levels: Levels, start: SeedAttempt, moves: int, budget: Budget, *, keep: int = 3
) -> list[SeedAttempt]:
    """Up to `keep` clear seeds of different classes, cheapest first; the shortened `start` may be among them.

    Args:
        levels: of the problem that `start` belongs to.
        start: clear curves of any origin; what is not clear comes back as it is.
        moves: tried in all, fewer only once the budget's deadline has passed.
    """
    planner = _planner(levels, start.curves) if start.clear else None
    if planner is None or not planner.movers:
        return [start]
    walk = _Walk(levels, planner, start.curves, np.random.default_rng(budget.rng_seed))
    tried = 0
    while tried < moves and not budget.spent():
        walk.move()
        tried += 1
    record = replace(start.record, tries=start.tries + tried)
    found = [
        SeedAttempt(f"{start.found_by}, improved", curves, clear=True, record=record)
        for curves in walk.best_of_classes(keep)
        if not verify(levels.problem, curves)
    ]
    return found or [start]


def cheapest_start(levels: Levels, seeds: int, budget: Budget) -> SeedAttempt:
    """The cheapest of so many seeds of `LeastCost`, from the budget's random number and those after it, by
    motion for even ones and by length for odd ones.

    An attempt that is not clear where none of them is.
    """
    best, least = SeedAttempt(LeastCost.name), np.inf
    for number in range(seeds):
        if budget.spent():
            break
        rng_seed = budget.rng_seed + number
        seeder = LeastCost(levels, by_length=rng_seed % 2 == 1)
        found = seeder.attempt(replace(budget, rng_seed=rng_seed))
        if not found.clear:
            best = best if best.clear else found
            continue
        required = held_requirement(
            levels.problem, found.curves, levels.at(_margin(levels)).required
        )
        shortened = take_shortcuts(levels.problem, found.curves, required)
        cost = total_kinetic_cost(levels.problem.masses, shortened)
        if cost < least:
            best, least = found, cost
    return best


def _margin(levels: Levels) -> float:
    return levels.problem.scene.seeding.margin


def _planner(levels: Levels, curves: Sequence[FloatArray]) -> LayeredPlanner | None:
    """A planner on the widest margin whose roadmap connects everybody, None where there is none."""
    for margin in (_margin(levels), *SMALLER_MARGINS):
        level = levels.at(margin)
        if level.journeys.stranded():
            continue
        planner = level.planner(1, _required(level, curves))
        if not planner.too_late():
            return planner
    return None


def _required(level: Level, curves: Sequence[FloatArray]) -> Requirement:
    """What the curves hold of the level's margin, but no less than what counts as touching."""
    held = held_requirement(level.problem, curves, level.required)
    floor = np.minimum(level.required.rods, LEAST_HELD * level.problem.distance)
    return Requirement(np.maximum(held.rods, floor), np.minimum(held.walls, level.required.walls))


@dataclass
class _State:
    """A set of clear curves and what it costs when shortened."""

    cost: float
    shortened: list[FloatArray]


@dataclass
class _Exchange:
    """Curves that some agents would have instead, and what their rods block."""

    curves: dict[int, FloatArray] = field(default_factory=dict)
    blocks: dict[int, Blocks] = field(default_factory=dict)


class _Walk:
    """The present state, its reservations, and the cheapest states there were."""

    def __init__(
        self,
        levels: Levels,
        planner: LayeredPlanner,
        curves: Sequence[FloatArray],
        rng: np.random.Generator,
    ) -> None:
        self._planner = planner
        self._problem: PlanningProblem = planner.problem
        self._rng = rng
        self._costs = (
            move_costs(planner),
            space_time_length(planner.graph, planner.grid.height),
        )
        self._least = _least_costs(levels)
        self._reserved = CurveSet(planner)
        planner.reset()
        for agent, curve in enumerate(curves):
            self._reserved.put(agent, curve)
        for agent in planner.movers:
            heed()
            planner.add(self._reserved.blocks(agent))
        self._state = self._valued(list(curves))
        self._best = [self._state]

    def move(self) -> None:
        """Try other curves for a few agents, and keep them where that pays."""
        group = self._group()
        exchange = self._replanned(group)
        if exchange is not None:
            curves = [
                exchange.curves.get(agent, curve)
                for agent, curve in enumerate(self._reserved.all_curves())
            ]
            trial = self._valued(curves)
            limit = 1.0 + TEMPERATURE * float(self._rng.exponential())
            if trial.cost < self._state.cost * limit:
                self._accept(trial, exchange)
                return
        self._put_back(group, exchange)

    def best_of_classes(self, count: int) -> list[list[FloatArray]]:
        """The cheapest shortened curves of up to `count` different classes, cheapest first."""
        found: dict[bytes, list[FloatArray]] = {}
        for state in sorted(self._best, key=lambda state: state.cost):
            found.setdefault(signature(self._problem, state.shortened), state.shortened)
            if len(found) == count:
                break
        return list(found.values())

    def _group(self) -> list[int]:
        """An agent drawn by what it pays beyond its own least, and some that pass near it."""
        movers = np.array(self._planner.movers)
        excess = np.array(
            [self._own_cost(int(agent)) - self._least[agent] for agent in movers]
        )  # fmt: skip
        # Whoever pays its least may be in another's way; everybody has a chance.
        excess = np.maximum(excess, 0.02 * max(float(excess.max()), 1e-12))
        first = int(self._rng.choice(movers, p=excess / excess.sum()))
        size = int(self._rng.integers(1, min(LARGEST_NEIGHBOURHOOD, len(movers)) + 1))
        near = self._reserved.nearest(first, NEIGHBOURS, NEARBY)
        free = np.array([agent for agent in near if agent in self._planner.movers], dtype=np.int64)
        return [first, *(int(agent) for agent in self._rng.permutation(free)[: size - 1])]

    def _own_cost(self, agent: int) -> float:
        return kinetic_cost(float(self._problem.masses[agent]), self._state.shortened[agent])

    def _replanned(self, group: list[int]) -> _Exchange | None:
        """Other curves of `group`, reserved in place of the old ones; None where one finds no way."""
        for agent in group:
            self._planner.remove(self._reserved.blocks(agent))
        base = self._costs[int(self._rng.integers(2))]
        cost = base * (1.0 + NOISE * self._rng.random(len(base)))
        exchange = _Exchange()
        for agent in (int(agent) for agent in self._rng.permutation(np.array(group))):
            if self._rng.random() < CHEAPEST:
                path = self._planner.cheapest_path(agent, cost, HARD)
            else:
                slack = max(int(self._planner.slack[agent]), 0)
                path = self._planner.path(agent, int(self._rng.integers(0, slack // 2 + 2)))
            if path is None:
                self._take_back(exchange)
                return None
            exchange.curves[agent] = self._planner.curve(agent, path)
            exchange.blocks[agent] = self._planner.blocks(agent, exchange.curves[agent])
            self._planner.add(exchange.blocks[agent])
        return exchange

    def _take_back(self, exchange: _Exchange) -> None:
        for blocks in exchange.blocks.values():
            self._planner.remove(blocks)

    def _put_back(self, group: list[int], exchange: _Exchange | None) -> None:
        """Reserve the old curves of `group` again."""
        if exchange is not None:
            self._take_back(exchange)
        for agent in group:
            self._planner.add(self._reserved.blocks(agent))

    def _accept(self, trial: _State, exchange: _Exchange) -> None:
        for agent, curve in exchange.curves.items():
            self._reserved.put(agent, curve)
        self._state = trial
        self._best.append(trial)
        if len(self._best) > 2 * REMEMBERED:
            self._best = sorted(self._best, key=lambda state: state.cost)[:REMEMBERED]

    def _valued(self, curves: list[FloatArray]) -> _State:
        """What clear `curves` cost when shortened."""
        shortened = take_shortcuts(self._problem, curves, self._planner.required, rounds=ROUNDS)
        return _State(total_kinetic_cost(self._problem.masses, shortened), shortened)


def _least_costs(levels: Levels) -> FloatArray:
    """(A,) kinetic cost of everybody on its own shortest way at constant speed, 0 where none is known."""
    from stplan.seeding.elastic_bands.geodesics import geodesic_curves

    problem = levels.problem
    alone = geodesic_curves(problem, levels.ways)
    return np.array(
        [
            0.0 if curve is None else kinetic_cost(float(mass), curve)
            for mass, curve in zip(problem.masses, alone, strict=True)
        ]
    )
