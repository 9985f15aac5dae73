"""Seeding by joint search: everybody's position at once, on coarse roadmaps, for tightly coupled groups.

Planners that take agents one after another, or repair a few at a time, fail where nobody can pass before
all others have made room. Here all agents are searched at once (`lacam`), which is complete on its roadmap:
what is exhausted has been proven not to exist on it. Roadmaps go from ones with room for one agent a vertex
to finer ones; what is found becomes curves by `move_schedule`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.deadline import heed
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, requirement
from stplan.problem.verification import verify
from stplan.reasons import Reason
from stplan.seeding.infeasibility import no_way_past
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.graph import Graph
from stplan.seeding.search.joint import timed_curves
from stplan.seeding.search.joint_step import Company
from stplan.seeding.search.journeys import Journeys
from stplan.seeding.search.lacam import (
    EXHAUSTED,
    FOUND,
    UNFINISHED,
    explore,
    new_memory,
    steps_found,
)
from stplan.seeding.search.levels import Levels, with_ways
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord

# Larger groups are hardly ever coupled as a whole.
MOST_AGENTS = 40
# Vertices so many diameters apart, the coarsest first.
DIAMETERS = (1.0, 0.7, 0.5)
# Rounds over all roadmaps: searches from different random numbers on each, and the iterations of each.
ROUNDS = ((2, 50_000), (1, 500_000), (1, 2_000_000))
MOST_TRIES = 100
# Longer ways are not worth making curves of: other random numbers find shorter ones.
MOST_STEPS = 250
# The clock is looked at every so many iterations.
CHUNK = 1000
# Ends keep what they have; everybody else is kept this share further apart than has to be.
EASE = 1e-6


@dataclass(frozen=True)
class _Place:
    """A coarse roadmap of a margin, and the agents on it."""

    margin: float
    required: Requirement
    graph: Graph
    company: Company


@dataclass(frozen=True)
class JointSearch:
    """Clear curves for everybody from a complete search of their joint positions."""

    name: ClassVar = "joint search"
    levels: Levels

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Roadmap after roadmap, short searches first, then longer ones, until one has a way."""
        if not self._fits():
            return SeedAttempt(self.name)
        problem = self.levels.problem
        exhausted: dict[int, tuple[Reason, ...]] = {}
        tries = 0
        for searches, iterations in ROUNDS:
            for number, place in enumerate(self._places):
                for _ in range(searches):
                    if number in exhausted or budget.spent():
                        break
                    tries += 1
                    rng_seed = MOST_TRIES * budget.rng_seed + tries
                    status, curves = _searched(problem, place, rng_seed, iterations, budget)
                    if curves is not None:
                        record = SeedRecord(margin=place.margin, tries=tries)
                        return SeedAttempt(self.name, curves, clear=True, record=record)
                    if status == EXHAUSTED and place.company.following:
                        movers = range(problem.num_agents)
                        exhausted[number] = no_way_past(problem, movers, place.graph.num_vertices)
        reasons = exhausted[max(exhausted)] if exhausted else ()
        return SeedAttempt(self.name, reasons=reasons).counting(tries)

    def _fits(self) -> bool:
        """Whether there is anything to search for."""
        problem = self.levels.problem
        together = float(problem.start_times.max()) < float(problem.max_times.min())
        direct = all(len(stops) == 2 for stops in problem.stops)
        return 2 <= problem.num_agents <= MOST_AGENTS and together and direct

    @cached_property
    def _places(self) -> list[_Place]:
        """The roadmaps that connect everybody, the coarsest and widest margins first."""
        return list(self._all_places())

    def _all_places(self) -> Iterator[_Place]:
        from stplan.seeding.search.coarse_roadmap import coarse_roadmap

        problem = self.levels.problem
        known: set[bytes] = set()
        margins = margin_ladder(problem.scene.seeding.margin)
        for margin in dict.fromkeys((margins[0], margins[-1])):
            required = with_ways(requirement(problem, margin), problem.radii, self.levels.ways)
            for diameters in DIAMETERS:
                roadmap = coarse_roadmap(problem, required, diameters)
                if roadmap is None or roadmap.graph.vertices.tobytes() in known:
                    continue
                known.add(roadmap.graph.vertices.tobytes())
                journeys = Journeys(problem, roadmap.graph, roadmap.place_of, required)
                if not journeys.stranded():
                    company = _company(problem, roadmap.graph, journeys)
                    for own in (company, company._replace(following=False)):
                        yield _Place(margin, required, roadmap.graph, own)


def _company(problem: PlanningProblem, graph: Graph, journeys: Journeys) -> Company:
    """All agents on a graph; they keep R, where their ends leave them that."""
    start = np.array(journeys.start, dtype=np.int64)
    goal = np.array([targets[-1] for targets in journeys.targets], dtype=np.int64)
    apart = np.where(problem.collides, problem.distance * (1.0 + EASE), 0.0)
    for ends in (start, goal):
        step = graph.vertices[ends][:, None] - graph.vertices[ends][None]
        apart = np.minimum(apart, np.hypot(step[..., 0], step[..., 1]) * (1.0 - 1e-9))
    np.fill_diagonal(apart, 2.0 * problem.radii)
    to_go = np.stack(
        [_lengths_to(graph, int(end), free) for end, free in zip(goal, journeys.free, strict=True)]
    )
    free = np.stack(journeys.free)
    return Company(start, goal, to_go, free, apart, graph.vertices, graph.leaving, following=True)


def _lengths_to(graph: Graph, goal: int, free: BoolArray) -> FloatArray:
    """(V,) lengths of the shortest ways to a vertex over free moves, m."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    heed()
    moves = np.flatnonzero(free)
    ends = (graph.move_from[moves], graph.move_to[moves])
    shape = (graph.num_vertices, graph.num_vertices)
    found = dijkstra(csr_array((graph.length[moves], ends), shape=shape), indices=[goal])
    return np.ascontiguousarray(found[0])


def _searched(
    problem: PlanningProblem, place: _Place, rng_seed: int, iterations: int, budget: Budget
) -> tuple[int, list[FloatArray] | None]:
    """How a search ended, and clear curves where it found any."""
    from stplan.seeding.search.move_schedule import scheduled_curves, without_loops

    company = place.company
    memory = new_memory(company, rng_seed)
    status = UNFINISHED
    for _ in range(iterations // CHUNK):
        status = explore(company, memory, CHUNK)
        if status != UNFINISHED or budget.spent():
            break
    if status != FOUND:
        return status, None
    steps = steps_found(memory)
    if len(steps) > MOST_STEPS:
        return status, None
    steps = without_loops(place.graph, steps, company.apart)
    begin, end = float(problem.start_times.max()), float(problem.max_times.min())
    group = range(problem.num_agents)
    timed = timed_curves(problem, place.graph, group, steps)
    for curves in (
        scheduled_curves(place.graph, steps, company.apart, begin, end),
        [timed[agent] for agent in group],
    ):
        if curves is not None:
            started = [_from_start(problem, agent, curve) for agent, curve in enumerate(curves)]
            if not verify(problem, started):
                return status, started
    return status, None


def _from_start(problem: PlanningProblem, agent: int, curve: FloatArray) -> FloatArray:
    """`curve` from the agent's own start time on, its ends to the last bit."""
    first = np.array([*problem.starts[agent], problem.start_times[agent]])
    if curve[0, 2] > first[2]:
        return np.ascontiguousarray(np.vstack([first, curve]))
    return curve
