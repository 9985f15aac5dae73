"""The journeys of all agents on a graph, and how many layers of time they need."""

from __future__ import annotations

import math

import numpy as np

from stplan.arrays import BoolArray, IntArray
from stplan.deadline import heed
from stplan.problem.clearance import STRICT
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.seeding.search.graph import UNREACHABLE, Graph
from stplan.seeding.search.journey import Journey, shortest_way

# Moves exactly as far off the walls as required are none, whatever the rounding: a little further than where
# verification calls them clear.
CLEAR = STRICT * (1.0 + 1e-9)
LEAST_LAYERS = 16
# Agents that queue at one place need more layers than the way is long: one by one they pass.
LAYERS_IN_QUEUE = 10
SHORT_QUEUE = 4
# Where arrivals are to be early, this part of the moves are no longer than a layer at top speed.
MOST_MOVES = 0.9


class Journeys:
    """Where every agent has to go on a graph, whatever the layers.

    Attributes:
        start: (A,) vertex.
        targets: waypoints and goal of every agent as vertices.
        free: (M,) moves clear of the walls, of every agent.
        hops: (legs, V) hops still to go on every leg, of every agent.
        of: all of these, of every agent.
        distance: (A,) hops from start to goal, UNREACHABLE where there is no way.
    """

    def __init__(
        self, problem: PlanningProblem, graph: Graph, place_of: IntArray, required: Requirement
    ) -> None:
        self.start: list[int] = []
        self.targets: list[IntArray] = []
        self.free: list[BoolArray] = []
        self.hops: list[IntArray] = []
        masks: dict[float, BoolArray] = {}
        position = 0
        for agent, points in enumerate(problem.stops):
            heed()
            places = place_of[position : position + len(points)]
            position += len(points)
            limit = (
                CLEAR * float(required.walls[agent]) if problem.heeds_walls[agent] else -math.inf
            )
            if limit not in masks:
                masks[limit] = graph.free_moves(limit)
            self.start.append(int(places[0]) if len(places) else 0)
            self.targets.append(places[1:])
            self.free.append(masks[limit])
            self.hops.append(_hops_of_legs(graph, places[1:], masks[limit]))
        parts = zip(self.start, self.targets, self.hops, self.free, strict=True)
        self.of = [Journey(*part) for part in parts]
        self.distance = np.array(
            [
                int(hops[0, start]) if len(hops) else 0
                for hops, start in zip(self.hops, self.start, strict=True)
            ],
            dtype=np.int64,
        )

    def stranded(self) -> list[int]:
        """Agents whose start and goal are not connected."""
        return [int(agent) for agent in np.flatnonzero(self.distance >= UNREACHABLE)]


def _hops_of_legs(graph: Graph, targets: IntArray, free: BoolArray) -> IntArray:
    """(legs, V) hops to the goal through the targets that are left on each leg."""
    hops = np.empty((len(targets), graph.num_vertices), dtype=np.int64)
    beyond = 0
    for leg in range(len(targets) - 1, -1, -1):
        near = graph.hops_to(int(targets[leg]), free)
        hops[leg] = np.minimum(near + beyond, UNREACHABLE)
        if leg > 0:
            beyond = int(hops[leg, targets[leg - 1]])
    return hops


def automatic_layers(problem: PlanningProblem, graph: Graph, journeys: Journeys) -> int:
    """Twice the hops of the longest way, and some for each agent that has to queue.

    Ways are counted where the time for them is shortest. The queue is that of the place which most
    shortest ways pass.
    """
    span = float(problem.max_times.max() - problem.start_times.min())
    movers = np.flatnonzero(~problem.prescribed)
    windows = (problem.max_times - problem.start_times)[movers]
    needed = 2.0 * journeys.distance[movers] * span / windows
    queue = busiest_place(problem, graph, journeys)
    longest = max(LEAST_LAYERS, math.ceil(float(needed.max(initial=0.0))))
    return longest + LAYERS_IN_QUEUE * max(queue - SHORT_QUEUE, 0)


def hasty_layers(problem: PlanningProblem, graph: Graph) -> int:
    """As many as make most moves of a layer as fast as the slowest agent may be, so that arrivals are early.

    The few that are longer are shortened or slowed down afterwards.
    """
    span = float(problem.max_times.max() - problem.start_times.min())
    limits = [agent.max_speed for agent in problem.scene.agents if agent.max_speed is not None]
    walked = graph.length[graph.num_vertices :]
    if not limits or not len(walked):
        return LEAST_LAYERS
    hop = float(np.quantile(walked, MOST_MOVES))
    return max(LEAST_LAYERS, math.ceil(span * min(limits) / hop))


def busiest_place(problem: PlanningProblem, graph: Graph, journeys: Journeys) -> int:
    """How many agents' shortest ways come through the busiest square of two radii."""
    cell = 2.0 * float(problem.radii.min())
    squares = np.floor(graph.vertices / cell).astype(np.int64)
    _, square_of = np.unique(squares, axis=0, return_inverse=True)
    square_of = np.ravel(square_of).astype(np.int64)
    visits = np.zeros(int(square_of.max()) + 1, dtype=np.int64)
    for agent in np.flatnonzero(~problem.prescribed):
        heed()
        if journeys.distance[agent] < UNREACHABLE:
            way = shortest_way(journeys.of[agent], graph.leaving)
            visits[np.unique(square_of[way])] += 1
    return int(visits.max())
