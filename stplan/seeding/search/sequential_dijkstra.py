"""The paper's initial paths: sequential Dijkstra on the mesh extruded into time layers.

The mesh has everybody's shortest way among its edges, so that nobody misses it for the mesh's spacing.
Agents are planned one after another, in scene order. Each finds the way of least space-time length
sum sqrt(dx^2 + dy^2 + (c dt)^2) along waiting and walking edges of the mesh that are clear of the
walls and of the rods of the agents before it; then its own rod is reserved, which wipes out the
edges within the agents' distance of it. An agent that finds no way goes first in the next order;
when everybody has been first, orders are random; then layers are added.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.callbacks import Stop
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, requirement
from stplan.problem.verification import verify
from stplan.reasons import Reason
from stplan.seeding.infeasibility import no_order, stranded
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.journeys import Journeys
from stplan.seeding.search.layered_dijkstra import HARD, space_time_length
from stplan.seeding.search.levels import Level, out_of_layers, tracks_of, with_ways
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord

if TYPE_CHECKING:
    from stplan.seeding.search.roadmap import Roadmap
    from stplan.seeding.search.shortest_ways import Way

LAYER_FACTORS = (1, 2, 4)


@dataclass(frozen=True)
class SequentialDijkstra:
    """Clear curves by sequential Dijkstra on the seeding mesh of the scene."""

    name: ClassVar = "dijkstra"
    problem: PlanningProblem

    @cached_property
    def ways(self) -> list[Way | None]:
        """Every agent's shortest way around the walls."""
        from stplan.seeding.search.shortest_ways import shortest_ways

        return shortest_ways(self.problem)

    @cached_property
    def roadmap(self) -> Roadmap:
        """The edges of the mesh, with all stops among its vertices (also where pairs meet), and all ways."""
        from stplan.seeding.search.roadmap import mesh_roadmap
        from stplan.world import build_seeding_mesh

        problem = self.problem
        stops = np.vstack(problem.stops)
        mesh = build_seeding_mesh(problem.scene, problem.free_space, stops)
        tracks = tracks_of(self.ways, self._required(problem.scene.seeding.margin))
        return mesh_roadmap(mesh, problem.free_space, stops, tracks)

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The journeys on the mesh, margin by margin."""
        return tuple(self._level(m) for m in margin_ladder(self.problem.scene.seeding.margin))

    def _level(self, margin: float) -> Level:
        required = self._required(margin)
        graph = self.roadmap.graph
        journeys = Journeys(self.problem, graph, self.roadmap.place_of, required)
        return Level(self.problem, margin, required, graph, journeys)

    def _required(self, margin: float) -> Requirement:
        return with_ways(requirement(self.problem, margin), self.problem.radii, self.ways)

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Few layers and the widest margin first."""
        problem = self.problem
        rng = np.random.default_rng(budget.rng_seed)
        reasons: tuple[Reason, ...] = ()
        tries = 0
        for factor in LAYER_FACTORS:
            for level in self.levels:
                cut_off = level.journeys.stranded()
                if cut_off:
                    reasons = reasons or stranded(problem, cut_off, level.margin, "mesh")
                    continue
                planner = level.planner(factor)
                if planner.too_late():
                    reasons = reasons or out_of_layers(planner)
                    continue
                budget.progress(
                    f"Dijkstra: {level.graph.num_vertices} vertices, {planner.grid.count} layers"
                )
                curves, orders, failures = _in_orders(planner, rng, budget.spent)
                tries += orders
                faults = [] if curves is None else verify(problem, curves, planner.required)
                if curves is not None and not faults:
                    record = SeedRecord(margin=level.margin, tries=tries)
                    return SeedAttempt(self.name, curves, clear=True, record=record)
                unclear = tuple(Reason("not clear", fault.agents) for fault in faults)
                reasons = unclear or no_order(problem, failures)
                if budget.spent():
                    return SeedAttempt(self.name, reasons=reasons).counting(tries)
        return SeedAttempt(self.name, reasons=reasons).counting(tries)


def _in_orders(
    planner: LayeredPlanner, rng: np.random.Generator, stopped: Stop
) -> tuple[list[FloatArray] | None, int, IntArray]:
    """Curves or None, orders tried, and (A,) how often each agent found no way."""
    failures = np.zeros(planner.problem.num_agents, dtype=np.int64)
    order = list(planner.movers)
    cost = space_time_length(planner.graph, planner.grid.height)
    bumps = 0
    max_orders = 2 * len(order) + 4
    for attempt in range(max_orders):
        curves, failed = _sequential(planner, order, cost, stopped)
        if curves is not None:
            return curves, attempt + 1, failures
        failures[failed] += 1
        if stopped():
            return None, attempt + 1, failures
        if bumps < len(order) and order[0] != failed:
            order.remove(failed)
            order.insert(0, failed)
            bumps += 1
        else:
            order = [int(agent) for agent in rng.permutation(np.array(order))]
            bumps = 0
    return None, max_orders, failures


def _sequential(
    planner: LayeredPlanner, order: list[int], cost: FloatArray, stopped: Stop
) -> tuple[list[FloatArray] | None, int]:
    """Curves of all agents planned in `order` and -1, or None and the agent without a way."""
    planner.reset()
    curves = [path if path is not None else np.empty((0, 3)) for path in planner.problem.paths]
    for agent in order:
        path = None if stopped() else planner.cheapest_path(agent, cost, HARD)
        if path is None:
            return None, agent
        curves[agent] = planner.curve(agent, path)
        planner.add(planner.blocks(agent, curves[agent]))
    return curves, -1
