"""Other curves for a few agents of a finished plan: what large-neighbourhood search tries.

Replanning sends agents on their cheapest or earliest ways through the roadmap among the rods of all
others, which stay as they are. Kicks put agents on their own shortest ways at an even pace, or hurry them
first and let them idle later (or the other way round); whoever touches then is parted by relaxing everybody.
The first agent of a move is drawn by what it pays beyond its own least cost, the others by the same among
those it meets. Now and then everybody is planned anew, by large-neighbourhood search on seeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stplan.arrays import FloatArray
from stplan.callbacks import Stop, never
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import requirement
from stplan.problem.verification import verify
from stplan.seeding.elastic_bands.geodesics import geodesic_curves
from stplan.seeding.elastic_bands.relaxation import relax
from stplan.seeding.elastic_bands.tightening import tighten
from stplan.seeding.margins import SMALLER_MARGINS
from stplan.seeding.search.conflicts import CurveSet
from stplan.seeding.search.layered_dijkstra import HARD, space_time_length
from stplan.seeding.search.least_cost import move_costs
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.search.seed_improvement import cheapest_start, improve_seed, moves_in_a_second
from stplan.seeding.seeder import Budget
from stplan.seeding.shortcutting.shortcuts import prepare_seed

# Times R and r that proposals keep: finished plans graze each other, wider rods would leave no way.
MARGIN = SMALLER_MARGINS[0]
# Multiple of the roadmap's own layers: finer in time than a first seed, as rods are dense.
LAYERS = 2
# Costs of moves are random within this share.
NOISE = 0.3
# Those an agent meets: at most so many, whose rods come within so many required distances.
NEIGHBOURS = 12
NEARBY = 3.0
# Relaxation after a kick: what is not parted soon is not worth it.
KICK_KNOTS = 60
KICK_SWEEPS = 240
# A kicked agent goes all the time it has with this probability, else in a part of it, at least so long.
WHOLE_TIME = 0.5
LEAST_PART = 0.2
# A warped clock runs between 1 - WARP and 1 + WARP times as fast at the start.
WARP = 0.9
# Planning everybody anew: first seeds, of which the cheapest is improved by so many moves, in about so many
# seconds at most.
FIRST_SEEDS, SEED_MOVES, SEED_SECONDS = 3, 150, 3

Curves = list[FloatArray]


@dataclass(frozen=True)
class Move:
    """A kind of proposal: what is done, to how many agents.

    Attributes:
        size: agents that are changed, 0 where all are.
        worth: how often it is tried before anything is known, relative to others.
        effort: what proposing takes, in iterations of an optimisation of the same agents.
    """

    kind: str
    size: int
    worth: float = 1.0
    effort: float = 5.0

    def __str__(self) -> str:
        """As records name it."""
        return f"{self.kind} {self.size}" if self.size else self.kind


CHEAPEST_MOTION, CHEAPEST_LENGTH, EARLIEST = "cheapest motion", "shortest rod", "earliest"
GEODESIC, CLOCK, ANEW = "own way", "clock", "anew"
# In the order of what they gained for their time on tight scenes.
MOVES = (
    Move(CLOCK, 2),
    Move(GEODESIC, 2),
    Move(GEODESIC, 1),
    Move(CHEAPEST_MOTION, 1),
    Move(CHEAPEST_LENGTH, 1),
    Move(CHEAPEST_MOTION, 2),
    Move(EARLIEST, 1),
    Move(CLOCK, 4),
    Move(ANEW, 0, worth=0.4, effort=60.0),
)


@dataclass(frozen=True)
class _StoppedBudget(Budget):
    """A budget that is spent when somebody says so."""

    stopped: Stop = never

    def spent(self) -> bool:
        """Whether it is."""
        return self.stopped()


class Proposals:
    """Proposals for one problem, from the plan that is best so far."""

    def __init__(self, problem: PlanningProblem, rng: np.random.Generator) -> None:
        self._problem = problem
        self._rng = rng
        self._required = requirement(problem, MARGIN)
        self._movers = np.flatnonzero(~problem.prescribed)
        self._curves: Curves = []
        self._excess = np.empty(0)
        self._reserved: CurveSet | None = None

    @cached_property
    def ways(self) -> list[FloatArray | None]:
        """Every agent's shortest way at an even pace, None where none is known."""
        return geodesic_curves(self._problem, self._levels.ways)

    def start_from(self, curves: Sequence[FloatArray], excess: FloatArray) -> None:
        """Propose changes to `curves`, whose agents pay `excess` (A,) beyond their own least cost."""
        self._curves = [np.array(curve) for curve in curves]
        floor = 1e-3 * max(float(excess.max()), 1e-300)
        self._excess = np.where(self._problem.prescribed, 0.0, np.maximum(excess, floor))
        self._reserved = None

    def propose(self, move: Move, stopped: Stop) -> Curves | None:
        """Clear curves of all agents, prepared to be optimised; None where the move leads to none."""
        if move.kind == ANEW:
            return self._planned_anew(stopped)
        if move.kind in (GEODESIC, CLOCK):
            return self._kicked(move, stopped)
        return self._replanned(move, stopped)

    def _group(self, size: int) -> list[int]:
        """An agent drawn by its excess, and up to size - 1 of those it meets."""
        chance = self._excess / self._excess.sum()
        first = int(self._rng.choice(len(chance), p=chance))
        near = [agent for agent in self._near(first) if self._excess[agent] > 0.0]
        count = min(size - 1, len(near))
        if count <= 0:
            return [first]
        weights = self._excess[near] / self._excess[near].sum()
        others = self._rng.choice(near, size=count, replace=False, p=weights)
        return [first, *(int(agent) for agent in others)]

    def _near(self, agent: int) -> list[int]:
        """Agents that `agent` meets, nearest first; all others where there is no roadmap."""
        reserved = self._reservations()
        if reserved is None:
            return [int(other) for other in self._movers if other != agent]
        return reserved.nearest(agent, NEIGHBOURS, NEARBY)

    @cached_property
    def _levels(self) -> Levels:
        return Levels(self._problem)

    @cached_property
    def _planner(self) -> LayeredPlanner | None:
        """A planner on the roadmap, None where that does not connect everybody in time."""
        level = self._levels.at(MARGIN)
        if level.journeys.stranded():
            return None
        planner = level.planner(LAYERS)
        return None if planner.too_late() else planner

    def _reservations(self) -> CurveSet | None:
        """The plan's rods, all reserved."""
        if self._reserved is None and self._planner is not None:
            self._planner.reset()
            self._reserved = CurveSet(self._planner)
            for agent, curve in enumerate(self._curves):
                self._reserved.put(agent, curve)
            for agent in self._planner.movers:
                self._planner.add(self._reserved.blocks(agent))
        return self._reserved

    def _replanned(self, move: Move, stopped: Stop) -> Curves | None:
        """Other ways through the roadmap for a few agents, all others as they are."""
        reserved = self._reservations()
        if reserved is None or self._planner is None:
            return None
        planner = self._planner
        group = self._group(move.size)
        for agent in group:
            planner.remove(reserved.blocks(agent))
        new: dict[int, FloatArray] = {}
        added = []
        for agent in (int(agent) for agent in self._rng.permutation(np.array(group))):
            curve = _way(planner, move.kind, agent, self._rng)
            if curve is None:
                break
            new[agent] = curve
            added.append(planner.blocks(agent, curve))
            planner.add(added[-1])
        for blocks in added:
            planner.remove(blocks)
        for agent in group:
            planner.add(reserved.blocks(agent))
        if len(new) < len(group):
            return None
        curves = [new.get(agent, curve) for agent, curve in enumerate(self._curves)]
        paths = tuple(None if agent in new else curve for agent, curve in enumerate(curves))
        return self._prepared(replace(self._problem, paths=paths), curves, stopped)

    def _kicked(self, move: Move, stopped: Stop) -> Curves | None:
        """A few agents kicked, and everybody relaxed."""
        curves = list(self._curves)
        for agent in self._group(move.size):
            way = self.ways[agent]
            if move.kind == CLOCK:
                curves[agent] = _warped(curves[agent], self._rng)
            elif way is not None:
                curves[agent] = _in_part_of_its_time(way, self._rng)
        found = relax(
            self._problem,
            self._required,
            curves,
            num_knots=KICK_KNOTS,
            rng_seed=self._rng_seed(),
            max_sweeps=KICK_SWEEPS,
            stopped=stopped,
        )
        return self._prepared(self._problem, found.curves, stopped) if found.clear else None

    def _planned_anew(self, stopped: Stop) -> Curves | None:
        """Everybody planned anew."""
        budget = _StoppedBudget(rng_seed=self._rng_seed(), stopped=stopped)
        start = cheapest_start(self._levels, FIRST_SEEDS, budget)
        if not start.clear:
            return None
        moves = min(SEED_SECONDS * moves_in_a_second(self._levels), SEED_MOVES)
        found = improve_seed(self._levels, start, moves, budget, keep=1)[0]
        tight = tighten(
            self._problem, found.curves, self._required,
            rng_seed=self._rng_seed(), stopped=stopped,
        )  # fmt: skip
        return self._prepared(self._problem, tight, stopped)

    def _prepared(self, problem: PlanningProblem, curves: Curves, stopped: Stop) -> Curves | None:
        """Clear `curves` shortened and retimed, None where they are not clear after all."""
        if stopped() or verify(problem, curves):
            return None
        return prepare_seed(
            problem,
            curves,
            self._required,
            num_knots=problem.scene.solver.knots,
            rng_seed=self._rng_seed(),
            stopped=stopped,
        )

    def _rng_seed(self) -> int:
        return int(self._rng.integers(1 << 30))


def _way(
    planner: LayeredPlanner, kind: str, agent: int, rng: np.random.Generator
) -> FloatArray | None:
    """A way of `agent` among all rods reserved, None where there is none."""
    if kind == EARLIEST:
        slack = max(int(planner.slack[agent]), 0)
        path = planner.path(agent, int(rng.integers(0, slack // 2 + 2)))
    else:
        cost = (
            move_costs(planner)
            if kind == CHEAPEST_MOTION
            else space_time_length(planner.graph, planner.grid.height)
        )
        noisy = cost * (1.0 + NOISE * rng.random(len(cost)))
        path = planner.cheapest_path(agent, noisy, HARD)
    return None if path is None else planner.curve(agent, path)


def _warped(curve: FloatArray, rng: np.random.Generator) -> FloatArray:
    """A curve (n, 3) hurried first and idle later, or the other way round."""
    begin, end = curve[0, 2], curve[-1, 2]
    share = (curve[:, 2] - begin) / (end - begin)
    share += float(rng.uniform(-WARP, WARP)) * share * (1.0 - share)
    result = curve.copy()
    result[1:-1, 2] = (begin + (end - begin) * share)[1:-1]
    return result


def _in_part_of_its_time(way: FloatArray, rng: np.random.Generator) -> FloatArray:
    """A way (n, 3) as it is, or within a random part of its time, waiting before it."""
    low, high = sorted(float(draw) for draw in rng.random(2))
    if rng.random() < WHOLE_TIME or high - low < LEAST_PART:
        return way.copy()
    begin, end = way[0, 2], way[-1, 2]
    share = (way[:, 2] - begin) / (end - begin)
    hurried = way.copy()
    hurried[:, 2] = begin + (end - begin) * (low + (high - low) * share)
    return np.ascontiguousarray(np.vstack([way[:1], hurried]))
