"""Safe-interval path planning: the earliest arrival among reserved rods.

A state is a vertex during one interval of layers in which waiting there is free. Arriving earlier
in an interval is never worse (one can wait), so each interval is settled once: the search is
as large as the number of intervals, not of layers. Waypoints multiply the states by the number of
legs: leg p ends at waypoint p, the last leg at the goal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import BoolArray, IntArray
from stplan.compiled import kernel
from stplan.seeding.search.graph import UNREACHABLE, Graph
from stplan.seeding.search.heap import drop_root, push
from stplan.seeding.search.reservations import CountArray

StateArray = NDArray[np.int32]

# Columns of a state.
_VERTEX, _LEG, _FIRST, _LAST, _ARRIVAL, _PARENT, _NEXT = range(7)
_NOT_FOUND = -1
_OUT_OF_ROOM = -2


class SafeIntervalSearch:
    """The search on one graph, with its working memory.

    Attributes:
        expansions: states expanded by all searches so far.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.expansions = 0
        self._states: StateArray = np.empty((1 << 15, 7), dtype=np.int32)
        self._heap = np.empty((1 << 15, 3), dtype=np.int64)

    def path(
        self,
        start: int,
        targets: IntArray,
        hops: IntArray,
        free: BoolArray,
        table: CountArray,
        *,
        first_layer: int,
        last_layer: int,
        departure: int = 0,
        stays: bool,
    ) -> IntArray | None:
        """Vertices at layers `first_layer`, `first_layer` + 1, ... up to the arrival, or None.

        Args:
            start: vertex at `first_layer`.
            targets: (P,) vertices to reach in order, the goal last.
            hops: (P, V) fewest hops to the goal on leg p, UNREACHABLE where there is no way.
            free: (M,) moves clear of the walls.
            table: (M, L) counts of blocking rods.
            last_layer: latest layer of arrival.
            departure: the start is not left before this layer.
            stays: the goal must be free from arrival to the last layer of the table.
        """
        while True:
            path, expansions = _search(
                start, targets, hops, free, table, first_layer, last_layer, departure, stays,
                self.graph.out_offsets, self.graph.out_moves, self.graph.move_to,
                self._states, self._heap,
            )  # fmt: skip
            if expansions != _OUT_OF_ROOM:
                self.expansions += max(expansions, 0)
                return path if len(path) else None
            self._states = np.empty((2 * len(self._states), 7), dtype=np.int32)
            self._heap = np.empty((2 * len(self._heap), 3), dtype=np.int64)


@kernel
def _state_at(
    vertex: int,
    leg: int,
    layer: int,
    num_vertices: int,
    table: CountArray,
    heads: StateArray,
    states: StateArray,
    count: int,
) -> tuple[int, int]:
    """State of `vertex` on `leg` whose interval holds `layer`, made if new; and the state count."""
    state = heads[leg * num_vertices + vertex]
    while state >= 0:
        if states[state, _FIRST] <= layer <= states[state, _LAST]:
            return state, count
        state = states[state, _NEXT]
    if count >= len(states):
        return -1, count
    first = layer
    while first > 0 and table[vertex, first - 1] == 0:
        first -= 1
    last = layer
    while last < table.shape[1] and table[vertex, last] == 0:
        last += 1
    states[count, _VERTEX] = vertex
    states[count, _LEG] = leg
    states[count, _FIRST] = first
    states[count, _LAST] = last
    states[count, _ARRIVAL] = 1 << 30
    states[count, _PARENT] = -1
    states[count, _NEXT] = heads[leg * num_vertices + vertex]
    heads[leg * num_vertices + vertex] = count
    return count, count + 1


@kernel
def _walk_back(state: int, first_layer: int, states: StateArray) -> IntArray:
    """Vertices at every layer from `first_layer` to the arrival in `state`."""
    last = states[state, _ARRIVAL]
    path = np.empty(last - first_layer + 1, np.int64)
    path[last - first_layer] = states[state, _VERTEX]
    while states[state, _PARENT] >= 0:
        before = states[state, _PARENT]
        for layer in range(states[before, _ARRIVAL], states[state, _ARRIVAL]):
            path[layer - first_layer] = states[before, _VERTEX]
        state = before
    for layer in range(first_layer, states[state, _ARRIVAL]):
        path[layer - first_layer] = states[state, _VERTEX]
    return path


@kernel
def _search(
    start: int,
    targets: IntArray,
    hops: IntArray,
    free: BoolArray,
    table: CountArray,
    first_layer: int,
    last_layer: int,
    departure: int,
    stays: bool,
    out_offsets: IntArray,
    out_moves: IntArray,
    move_to: IntArray,
    states: StateArray,
    heap: IntArray,
) -> tuple[IntArray, int]:
    """The path (empty if none) and the number of expansions, or _NOT_FOUND or _OUT_OF_ROOM."""
    nothing = np.empty(0, np.int64)
    num_layers = table.shape[1]
    num_vertices = hops.shape[1]
    num_legs = len(targets)
    heads = np.full(num_legs * num_vertices, -1, np.int32)
    begun = 0
    while begun < num_legs - 1 and start == targets[begun]:
        begun += 1
    if hops[begun, start] >= UNREACHABLE or not free[start]:
        return nothing, _NOT_FOUND
    arrival = max(departure, first_layer)
    for layer in range(first_layer, min(arrival, num_layers)):
        if table[start, layer] > 0:
            return nothing, _NOT_FOUND
    state, count = _state_at(start, begun, arrival, num_vertices, table, heads, states, 0)
    states[state, _ARRIVAL] = arrival
    size = 1
    heap[0, 0] = 0
    heap[0, 1] = state
    heap[0, 2] = arrival
    expansions = 0
    while size > 0:
        state = heap[0, 1]
        arrival = heap[0, 2]
        drop_root(heap, size)
        size -= 1
        if states[state, _ARRIVAL] != arrival:
            continue
        expansions += 1
        vertex = int(states[state, _VERTEX])
        leg = int(states[state, _LEG])
        until = int(states[state, _LAST])
        if leg == num_legs - 1 and vertex == targets[leg] and (not stays or until == num_layers):
            return _walk_back(state, first_layer, states), expansions
        for place in range(out_offsets[vertex], out_offsets[vertex + 1]):
            move = out_moves[place]
            other = move_to[move]
            if not free[move]:
                continue
            next_leg = leg
            while next_leg < num_legs - 1 and other == targets[next_leg]:
                next_leg += 1
            to_go = hops[next_leg, other]
            if to_go >= UNREACHABLE:
                continue
            layer = arrival
            while layer <= until and layer + 1 + to_go <= last_layer:
                if table[move, layer] > 0:
                    layer += 1
                    continue
                found, count = _state_at(
                    other, next_leg, layer + 1, num_vertices, table, heads, states, count
                )
                if found < 0 or size >= len(heap):
                    return nothing, _OUT_OF_ROOM
                if layer + 1 < states[found, _ARRIVAL]:
                    states[found, _ARRIVAL] = layer + 1
                    states[found, _PARENT] = state
                    # Least arrival at the goal first, and of equals the one nearest to it.
                    key = ((layer + 1 + to_go) << 24) + to_go
                    push(heap, size, key, found, layer + 1)
                    size += 1
                # Leaving later is of use only to reach the next interval of the other vertex.
                layer = max(layer + 1, int(states[found, _LAST]))
    return nothing, expansions
