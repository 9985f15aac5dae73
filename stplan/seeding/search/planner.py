"""One problem on one graph and one grid of time layers: plan an agent, reserve or free its rod.

Agents that keep the same distances from everybody share a table of reservations (a class). Searches
over orders and neighbourhoods are built on this.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.deadline import passed
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.seeding.search.graph import Graph
from stplan.seeding.search.journey import Window
from stplan.seeding.search.journeys import Journeys
from stplan.seeding.search.layered_dijkstra import cheapest_path
from stplan.seeding.search.reservations import (
    MEMORY_LIMIT,
    BlockArray,
    Reservations,
    TimeGrid,
    table_bytes,
)
from stplan.seeding.search.safe_interval import SafeIntervalSearch
from stplan.seeding.search.soft_interval import SoftIntervalSearch

Blocks = tuple[BlockArray, ...]

# More tables than this are merged: a rod has to be entered in each of them.
MAX_CLASSES = 16
MOST_LAYERS = 4000
NO_BLOCKS: BlockArray = np.empty((0, 3), dtype=np.int32)


def classes(problem: PlanningProblem, required: Requirement) -> tuple[IntArray, FloatArray]:
    """Class of every agent (A,), and (K, A) the distance a class keeps from every agent's rod.

    A class keeps the least of what its members have to keep (they differ at most in how their
    fixed ends clip the margin); 0 where there is nothing to keep. Too many classes are merged by
    radius, and then keep the most.
    """
    keys: dict[bytes, int] = {}
    class_of = np.empty(problem.num_agents, dtype=np.int64)
    for agent in range(problem.num_agents):
        row = np.where(problem.collides[agent], problem.distance[agent], 0.0)
        row[agent] = 2.0 * problem.radii[agent]
        class_of[agent] = keys.setdefault(row.tobytes(), len(keys))
    kept = np.where(problem.collides, required.rods, 0.0)
    distances = np.empty((len(keys), problem.num_agents))
    for index in range(len(keys)):
        rows = kept[class_of == index]
        members = np.flatnonzero(class_of == index)
        rows[np.arange(len(members)), members] = np.inf
        distances[index] = rows.min(axis=0)
    distances[~np.isfinite(distances)] = 0.0
    if len(keys) <= MAX_CLASSES:
        return class_of, distances
    size = np.array([problem.radii[class_of == index].max() for index in range(len(keys))])
    rank = np.empty(len(keys), dtype=np.int64)
    rank[np.argsort(size, kind="stable")] = np.arange(len(keys)) * MAX_CLASSES // len(keys)
    merged = np.zeros((MAX_CLASSES, problem.num_agents))
    for index, other in enumerate(rank):
        merged[other] = np.maximum(merged[other], distances[index])
    return rank[class_of], merged


class LayeredPlanner:
    """Plans agents one at a time among the rods reserved so far.

    Attributes:
        required: the distances that planned curves hold, from rods and from walls.
        grid: time layers.
        first, last: (A,) layers of departure and of latest arrival.
        slack: (A,) layers an agent can lose on its shortest way, < 0 if it cannot make it.
        movers: agents that are planned (not `path` agents), in scene order.
    """

    def __init__(
        self,
        problem: PlanningProblem,
        graph: Graph,
        journeys: Journeys,
        required: Requirement,
        layers: int,
    ) -> None:
        self.problem = problem
        self.graph = graph
        self.journeys = journeys
        self.class_of, self.class_distance = classes(problem, required)
        kept = self.class_distance[self.class_of]
        self.required = Requirement(np.minimum(kept, kept.T), required.walls)
        self.movers = [int(agent) for agent in np.flatnonzero(~problem.prescribed)]
        begin = float(problem.start_times.min())
        end = float(problem.max_times.max())
        layers = min(layers, most_layers(graph, len(self.class_distance)))
        self.grid = TimeGrid(begin, (end - begin) / layers, layers, problem.time_scale)
        self.first = np.ceil((problem.start_times - begin) / self.grid.step - 1e-9).astype(int)
        self.last = np.floor((problem.max_times - begin) / self.grid.step + 1e-9).astype(int)
        self.last = np.minimum(self.last, layers)
        self.slack = self.last - self.first - journeys.distance
        self.reservations = Reservations(graph, self.grid, len(self.class_distance))
        self.search = SafeIntervalSearch(graph)
        self.soft_search = SoftIntervalSearch(graph)
        self._fixed = [
            (agent, self.blocks(agent, path))
            for agent, path in enumerate(problem.paths)
            if path is not None
        ]
        self.reset()

    def reset(self) -> None:
        """Forget all rods but those of agents whose motion is prescribed."""
        self.reservations.clear()
        for _, blocks in self._fixed:
            self.add(blocks)

    def path(self, agent: int, departure: int = 0) -> IntArray | None:
        """Vertices at the layers from ``first[agent]`` to the earliest arrival, or None, also out of time.

        `departure`: layers the agent is held at its start.
        """
        first, last = int(self.first[agent]), int(self.last[agent])
        if first > last or passed():
            return None
        table = self.reservations.tables[self.class_of[agent]]
        # A start between layers waits for the next one; its wait is checked as a whole layer.
        early = self.problem.start_times[agent] < self.grid.instant(first) - 1e-9 * self.grid.step
        if early and first > 0 and table[self.journeys.start[agent], first - 1] > 0:
            return None
        window = Window(first, last, bool(self.problem.stays[agent]), first + departure)
        return self.search.path(self.journeys.of[agent], window, table)

    def cheapest_path(self, agent: int, cost: FloatArray, penalty: float) -> IntArray | None:
        """Like `path`, of least `cost` (M,), passing through rods at a `penalty` each."""
        if passed():
            return None
        window = Window(
            int(self.first[agent]), int(self.last[agent]), bool(self.problem.stays[agent])
        )
        return cheapest_path(
            self.graph, self.journeys.of[agent], window,
            self.reservations.tables[self.class_of[agent]], cost, penalty,
        )  # fmt: skip

    def soft_path(self, agent: int, penalty: int) -> IntArray | None:
        """Like `path`, through rods where arriving so many layers later is as bad as touching one more."""
        if passed():
            return None
        window = Window(
            int(self.first[agent]), int(self.last[agent]), bool(self.problem.stays[agent])
        )
        table = self.reservations.tables[self.class_of[agent]]
        return self.soft_search.path(self.journeys.of[agent], window, table, penalty)

    def curve(self, agent: int, path: IntArray) -> FloatArray:
        """The world line (n, 3) of a path, waits joined to one segment."""
        problem = self.problem
        first = int(self.first[agent])
        times = self.grid.begin + (first + np.arange(len(path))) * self.grid.step
        # Rounding must not carry an arrival past the limit.
        times = np.minimum(times, problem.max_times[agent])
        knots = np.column_stack([self.graph.vertices[path], times])
        inner = np.ones(len(path), dtype=bool)
        inner[1:-1] = (path[1:-1] != path[:-2]) | (path[1:-1] != path[2:])
        knots = knots[inner]
        start_time = problem.start_times[agent]
        if knots[0, 2] - start_time > 1e-9 * self.grid.step:
            waits = len(path) > 1 and path[0] == path[1]
            knots = np.vstack([[*knots[0, :2], start_time], knots[1:] if waits else knots])
        knots[0] = [*problem.starts[agent], start_time]
        if len(knots) == 1:
            # On its goal already: a rod needs a length, however short.
            later = min(start_time + self.grid.step, float(problem.max_times[agent]))
            knots = np.vstack([knots, [*knots[0, :2], later]])
        knots[-1, :2] = problem.goals[agent]
        return np.ascontiguousarray(knots)

    def blocks(self, agent: int, curve: FloatArray) -> Blocks:
        """What the rod of `curve`, its tail included, blocks for every class."""
        return self._blocks(agent, self.problem.rod(agent, curve))

    def guard(self, agent: int, layers: int) -> Blocks:
        """What standing at the start for the first `layers` blocks for every class."""
        problem = self.problem
        start = [*problem.starts[agent], problem.time_scale * problem.start_times[agent]]
        until = [start[0], start[1], start[2] + layers * self.grid.height]
        return self._blocks(agent, np.array([start, until]))

    def _blocks(self, agent: int, rod: FloatArray) -> Blocks:
        return tuple(
            self.reservations.blocks(rod, float(distance)) if distance > 0 else NO_BLOCKS
            for distance in self.class_distance[:, agent]
        )

    def add(self, blocks: Blocks) -> None:
        """Reserve `blocks`."""
        for index, found in enumerate(blocks):
            self.reservations.add(index, found)

    def remove(self, blocks: Blocks) -> None:
        """Take back an `add`."""
        for index, found in enumerate(blocks):
            self.reservations.remove(index, found)

    def too_late(self) -> list[int]:
        """Agents that would be late even alone, on these layers."""
        return [agent for agent in self.movers if self.slack[agent] < 0]


def most_layers(graph: Graph, num_classes: int) -> int:
    """How many layers fit in memory."""
    return max(2, min(MOST_LAYERS, MEMORY_LIMIT // (table_bytes(graph, 1) * num_classes)))
