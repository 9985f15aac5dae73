"""The paper's initial paths: sequential Dijkstra on the mesh extruded into time layers.

Agents are planned one after another, in scene order. Each finds the way of least space-time length
sum sqrt(dx^2 + dy^2 + (c dt)^2) along waiting and walking edges of the mesh that are clear of the
walls and of the rods of the agents before it; then its own rod is reserved, which wipes out the
edges within the agents' distance of it. An agent that finds no way goes first in the next order;
when everybody has been first, orders are random; then layers are added.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import working_time
from stplan.problem.clearance import requirement, verify
from stplan.problem.planning_problem import PlanningProblem
from stplan.reasons import Reason
from stplan.scene.model import SeedingSettings
from stplan.seeding.infeasibility import no_order, stranded, too_few_layers
from stplan.seeding.search.layered_dijkstra import HARD, space_time_length
from stplan.seeding.search.planner import Journeys, LayeredPlanner, automatic_layers
from stplan.seeding.search.roadmap import mesh_roadmap
from stplan.seeding.search.schedule import SearchResult

if TYPE_CHECKING:
    from stplan.world import SeedingMesh

MARGINS = (1.02, 1.005, 1.001)
LAYER_FACTORS = (1, 2, 4)


def dijkstra_curves(
    problem: PlanningProblem,
    mesh: SeedingMesh,
    *,
    settings: SeedingSettings,
    progress: Callable[[str], None] | None = None,
) -> SearchResult:
    """Clear curves by sequential Dijkstra on `mesh`, or why there are none.

    Uses `margin`, `layers`, `time_limit` and `rng_seed` of `settings`.
    """
    say = progress or (lambda line: None)
    deadline = working_time() + settings.time_limit
    reasons: tuple[Reason, ...] = ()
    rng = np.random.default_rng(settings.rng_seed)
    roadmap = mesh_roadmap(mesh, np.vstack(problem.stops))
    tries = 0
    for factor in LAYER_FACTORS:
        for margin in (settings.margin, *(m for m in MARGINS if m < settings.margin)):
            required = requirement(problem, margin)
            journeys = Journeys(problem, roadmap.graph, roadmap.place_of, required)
            if journeys.stranded():
                reasons = reasons or stranded(problem, journeys.stranded(), margin, "mesh")
                continue
            layers = settings.layers or automatic_layers(problem, roadmap.graph, journeys)
            planner = LayeredPlanner(problem, roadmap.graph, journeys, required, factor * layers)
            if planner.too_late():
                reasons = reasons or too_few_layers(problem, planner.too_late(), planner.grid.count)
                continue
            say(f"Dijkstra: {roadmap.graph.num_vertices} vertices, {planner.grid.count} layers")
            curves, orders, failures = _in_orders(planner, rng, lambda: working_time() > deadline)
            tries += orders
            if curves is not None and not verify(problem, curves, planner.required):
                return SearchResult(curves, "dijkstra", margin, tries, ())
            reasons = no_order(problem, failures)
            if working_time() > deadline:
                return SearchResult(None, "", settings.margin, tries, reasons)
    return SearchResult(None, "", settings.margin, tries, reasons)


def _in_orders(
    planner: LayeredPlanner, rng: np.random.Generator, stopped: Callable[[], bool]
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
    planner: LayeredPlanner, order: list[int], cost: FloatArray, stopped: Callable[[], bool]
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
