"""Safe-interval path planning: the earliest arrival among reserved rods.

A state is a vertex during one interval of layers in which waiting there is free. Arriving earlier
in an interval is never worse (one can wait), so each interval is settled once: the search is
as large as the number of intervals, not of layers. Waypoints multiply the states by the number of
legs: leg p ends at waypoint p, the last leg at the goal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import IntArray
from stplan.compiled import inner, kernel
from stplan.deadline import passed
from stplan.geometry.growable import with_room
from stplan.seeding.search.graph import UNREACHABLE, Graph, MoveRows
from stplan.seeding.search.heap import drop_root, push
from stplan.seeding.search.journey import Journey, Window, leg_at
from stplan.seeding.search.reservations import CountArray

StateArray = NDArray[np.int32]

# Columns of a state.
VERTEX, LEG, FIRST, LAST, ARRIVAL, PARENT, NEXT = range(7)
STATE_COLUMNS = 7
# The clock is looked at every so many states that are taken from the queue.
CHUNK = 20_000


class SafeIntervalSearch:
    """The search on one graph, with its working memory."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self._states: StateArray = np.empty((1 << 15, STATE_COLUMNS), dtype=np.int32)
        self._heap: IntArray = np.empty((1 << 15, 3), dtype=np.int64)

    def path(self, journey: Journey, window: Window, table: CountArray) -> IntArray | None:
        """Vertices at layers `window.first`, ... up to the earliest arrival, or None.

        `table` (M, L) are counts of blocking rods. None, too, where the deadline passes before.
        """
        heads = np.full(journey.hops.shape, -1, np.int32)
        counts = np.zeros(2, np.int64)
        _begin(journey, window, table, heads, self._states, self._heap, counts)
        while counts[1] > 0:
            final, self._states, self._heap = _search(
                journey, window, self.graph.leaving, table, heads, self._states, self._heap,
                counts, CHUNK,
            )  # fmt: skip
            if final >= 0:
                return way_to(final, window.first, self._states)
            if passed():
                return None
        return None


@inner
def _state_at(
    vertex: int, leg: int, layer: int, table: CountArray, heads: StateArray, states: StateArray,
    count: int,
) -> tuple[int, int]:  # fmt: skip
    """State of `vertex` on `leg` whose interval holds `layer`, made if new; and the state count.

    `heads` (P, V) are the first states of every leg and vertex.
    """
    state = int(heads[leg, vertex])
    while state >= 0:
        if states[state, FIRST] <= layer <= states[state, LAST]:
            return state, count
        state = int(states[state, NEXT])
    first = layer
    while first > 0 and table[vertex, first - 1] == 0:
        first -= 1
    last = layer
    while last < table.shape[1] and table[vertex, last] == 0:
        last += 1
    states[count, VERTEX] = vertex
    states[count, LEG] = leg
    states[count, FIRST] = first
    states[count, LAST] = last
    states[count, ARRIVAL] = 1 << 30
    states[count, PARENT] = -1
    states[count, NEXT] = heads[leg, vertex]
    heads[leg, vertex] = count
    return count, count + 1


@kernel
def way_to(state: int, first_layer: int, states: StateArray) -> IntArray:
    """Vertices at every layer from `first_layer` to the arrival in `state`."""
    last = states[state, ARRIVAL]
    path = np.empty(last - first_layer + 1, np.int64)
    path[last - first_layer] = states[state, VERTEX]
    while states[state, PARENT] >= 0:
        before = states[state, PARENT]
        for layer in range(states[before, ARRIVAL], states[state, ARRIVAL]):
            path[layer - first_layer] = states[before, VERTEX]
        state = before
    for layer in range(first_layer, states[state, ARRIVAL]):
        path[layer - first_layer] = states[state, VERTEX]
    return path


@kernel
def _begin(
    journey: Journey, window: Window, table: CountArray, heads: StateArray, states: StateArray,
    heap: IntArray, counts: IntArray,
) -> None:  # fmt: skip
    """Enter the first state, if there is any way from the start.

    `heads` (P, V) come filled with -1; `counts` (2,), of states and of entries in the queue, with 0.
    """
    start, targets, hops, free = journey
    num_layers = table.shape[1]
    begun = leg_at(start, 0, targets)
    if hops[begun, start] >= UNREACHABLE or not free[start]:
        return
    arrival = max(window.departure, window.first)
    for layer in range(window.first, min(arrival, num_layers)):
        if table[start, layer] > 0:
            return
    state, counts[0] = _state_at(start, begun, arrival, table, heads, states, 0)
    states[state, ARRIVAL] = arrival
    heap[0, 0] = 0
    heap[0, 1] = state
    heap[0, 2] = arrival
    counts[1] = 1


@kernel
def _search(
    journey: Journey, window: Window, leaving: MoveRows, table: CountArray, heads: StateArray,
    states: StateArray, heap: IntArray, counts: IntArray, most: int,
) -> tuple[int, StateArray, IntArray]:  # fmt: skip
    """Search on, for at `most` so many states taken from the queue.

    The state at the goal, -1 if it is not found yet, and the working memory, which may have grown. Where
    nothing is left in the queue there is no way.
    """
    targets, hops, free = journey.targets, journey.hops, journey.free
    num_layers = table.shape[1]
    last_leg = len(targets) - 1
    count, size = counts[0], counts[1]
    taken = 0
    while size > 0 and taken < most:
        taken += 1
        state = heap[0, 1]
        arrival = heap[0, 2]
        drop_root(heap, size)
        size -= 1
        if states[state, ARRIVAL] != arrival:
            continue
        vertex = int(states[state, VERTEX])
        leg = int(states[state, LEG])
        until = int(states[state, LAST])
        if leg == last_leg and vertex == targets[leg] and (not window.stays or until == num_layers):
            return state, states, heap
        for place in range(leaving.offsets[vertex], leaving.offsets[vertex + 1]):
            move = leaving.moves[place]
            other = leaving.ends[move]
            if not free[move]:
                continue
            next_leg = leg_at(other, leg, targets)
            to_go = hops[next_leg, other]
            if to_go >= UNREACHABLE:
                continue
            # At most one of each for every layer.
            states = with_room(states, count + num_layers + 1)
            heap = with_room(heap, size + num_layers + 1)
            layer = arrival
            while layer <= until and layer + 1 + to_go <= window.last:
                if table[move, layer] > 0:
                    layer += 1
                    continue
                found, count = _state_at(other, next_leg, layer + 1, table, heads, states, count)
                if layer + 1 < states[found, ARRIVAL]:
                    states[found, ARRIVAL] = layer + 1
                    states[found, PARENT] = state
                    # Least arrival at the goal first, and of equals the one nearest to it.
                    key = ((layer + 1 + to_go) << 24) + to_go
                    push(heap, size, key, found, layer + 1)
                    size += 1
                # Leaving later is of use only to reach the next interval of the other vertex.
                layer = max(layer + 1, int(states[found, LAST]))
    counts[0], counts[1] = count, size
    return -1, states, heap
