"""Soft safe-interval search: a way that touches few of the reserved rods, found without going layer by layer.

In the manner of SIPPS (Li et al., *MAPF-LNS2: Fast Repairing for Multi-Agent Path Finding via Large
Neighborhood Search*, 2022). A state is a vertex during one interval of layers in which waiting there is
blocked by the same number of rods, none included. A label says when an interval is reached and how many rods
have been run into until then: whenever more rods are in the way than a moment before, so that a rod counts
once however long it is touched. Of two labels of an interval the earlier one of no more rods is as good; what
comes out of the queue first is the way of least arrival, each rod counting as so many layers. As with free
intervals, the search is as large as the number of intervals.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import IntArray
from stplan.compiled import inlined, inner, kernel
from stplan.deadline import passed
from stplan.geometry.growable import with_room
from stplan.seeding.search.graph import UNREACHABLE, Graph, MoveRows
from stplan.seeding.search.heap import drop_root, push
from stplan.seeding.search.journey import Journey, Window
from stplan.seeding.search.reservations import CountArray
from stplan.seeding.search.safe_interval import (
    ARRIVAL,
    CHUNK,
    FIRST,
    LAST,
    LEG,
    NEXT,
    PARENT,
    STATE_COLUMNS,
    VERTEX,
    StateArray,
    way_to,
)

# More columns of a label: rods run into, and rods that block waiting during its interval.
_TOUCHED, _BLOCKED = STATE_COLUMNS, STATE_COLUMNS + 1


class SoftIntervalSearch:
    """The search on one graph, with its working memory."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self._labels: StateArray = np.empty((1 << 12, STATE_COLUMNS + 2), dtype=np.int32)
        self._heap: IntArray = np.empty((1 << 12, 3), dtype=np.int64)

    def path(
        self, journey: Journey, window: Window, table: CountArray, penalty: int
    ) -> IntArray | None:
        """Vertices at layers `window.first`, ... up to the arrival, or None.

        None, too, where the deadline passes before it is found.

        Args:
            window: whose departure is not heeded.
            table: (M, L) counts of blocking rods.
            penalty: layers that arriving later is as bad as touching another rod.
        """
        heads = np.full(journey.hops.shape, -1, np.int32)
        counts = np.zeros(2, np.int64)
        tail = _rods_after(table[journey.targets[-1]], window.stays)
        _begin(journey, window, table, heads, self._labels, self._heap, counts)
        while counts[1] > 0:
            final, self._labels, self._heap = _search(
                journey, window, self.graph.leaving, table, tail, penalty, heads, self._labels,
                self._heap, counts, CHUNK,
            )  # fmt: skip
            if final >= 0:
                return way_to(final, window.first, self._labels)
            if passed():
                return None
        return None


@kernel
def _rods_after(counts: CountArray, stays: bool) -> IntArray:
    """(L + 1,) rods that come over one who waits from a layer on, given (L,) how many block waiting."""
    after = np.zeros(len(counts) + 1, np.int64)
    if stays:
        for layer in range(len(counts) - 1, 0, -1):
            after[layer] = after[layer + 1] + _more(counts[layer], counts[layer - 1])
    return after


@inlined
def _more(now: int, before: int) -> int:
    """How many rods have come, of those that block a move."""
    return int(np.int64(now) - np.int64(before)) if now > before else 0


@inner
def _interval(
    vertex: int, leg: int, instant: int, table: CountArray, heads: StateArray, labels: StateArray
) -> tuple[int, int]:
    """First and last instant of the interval of a vertex that holds an `instant`; of two the freer one."""
    layer = instant
    if instant > 0 and (
        instant == table.shape[1] or table[vertex, instant - 1] < table[vertex, instant]
    ):
        layer -= 1
    label = int(heads[leg, vertex])
    while label >= 0:
        if labels[label, FIRST] <= layer < labels[label, LAST]:
            return int(labels[label, FIRST]), int(labels[label, LAST])
        label = int(labels[label, NEXT])
    first, last, blocked = layer, layer + 1, table[vertex, layer]
    while first > 0 and table[vertex, first - 1] == blocked:
        first -= 1
    while last < table.shape[1] and table[vertex, last] == blocked:
        last += 1
    return first, last


@inner
def _enter(
    vertex: int, leg: int, interval: tuple[int, int], arrival: int, touched: int, parent: int,
    table: CountArray, heads: StateArray, labels: StateArray, count: int,
) -> bool:  # fmt: skip
    """Make a label, unless there is one as good."""
    label = int(heads[leg, vertex])
    while label >= 0:
        if (
            labels[label, FIRST] == interval[0]
            and labels[label, ARRIVAL] <= arrival
            and labels[label, _TOUCHED] <= touched
        ):
            return False
        label = int(labels[label, NEXT])
    labels[count, VERTEX], labels[count, LEG] = vertex, leg
    labels[count, FIRST], labels[count, LAST] = interval
    labels[count, ARRIVAL], labels[count, PARENT] = arrival, parent
    labels[count, NEXT] = heads[leg, vertex]
    labels[count, _TOUCHED] = touched
    labels[count, _BLOCKED] = table[vertex, interval[0]]
    heads[leg, vertex] = count
    return True


@inner
def _beaten(label: int, heads: StateArray, labels: StateArray) -> bool:
    """Whether a later label of the same interval is as good."""
    other = int(heads[labels[label, LEG], labels[label, VERTEX]])
    # The newest come first.
    while other > label:
        if (
            labels[other, FIRST] == labels[label, FIRST]
            and labels[other, ARRIVAL] <= labels[label, ARRIVAL]
            and labels[other, _TOUCHED] <= labels[label, _TOUCHED]
        ):
            return True
        other = int(labels[other, NEXT])
    return False


@kernel
def _begin(
    journey: Journey, window: Window, table: CountArray, heads: StateArray, labels: StateArray,
    heap: IntArray, counts: IntArray,
) -> None:  # fmt: skip
    """Enter the first label, if there is any way from the start.

    `heads` (P, V) come filled with -1; `counts` (2,), of labels and of entries in the queue, with 0.
    """
    start, targets, hops, free = journey
    begun = 0
    while begun < len(targets) - 1 and start == targets[begun]:
        begun += 1
    if window.first + hops[begun, start] > window.last or not free[start]:
        return
    layer = min(window.first, table.shape[1] - 1)
    first, last = layer, layer + 1
    while last < table.shape[1] and table[start, last] == table[start, layer]:
        last += 1
    touched = int(table[start, layer])
    _enter(start, begun, (first, last), window.first, touched, -1, table, heads, labels, 0)
    push(heap, 0, 0, 0, 0)
    counts[0] = counts[1] = 1


@kernel
def _search(
    journey: Journey, window: Window, leaving: MoveRows, table: CountArray, tail: IntArray,
    penalty: int, heads: StateArray, labels: StateArray, heap: IntArray, counts: IntArray,
    most: int,
) -> tuple[int, StateArray, IntArray]:  # fmt: skip
    """Search on, for at `most` so many labels taken from the queue.

    The label at the goal, -1 if it is not found yet, and the working memory, which may have grown. An entry
    of the queue says in its last column whether it stands for the whole way.
    """
    targets, hops, free = journey.targets, journey.hops, journey.free
    num_layers = table.shape[1]
    last_leg = len(targets) - 1
    count, size = counts[0], counts[1]
    taken = 0
    while size > 0 and taken < most:
        taken += 1
        label, final = heap[0, 1], heap[0, 2]
        drop_root(heap, size)
        size -= 1
        if final == 1:
            return label, labels, heap
        if _beaten(label, heads, labels):
            continue
        vertex, leg = int(labels[label, VERTEX]), int(labels[label, LEG])
        arrival, until = int(labels[label, ARRIVAL]), int(labels[label, LAST])
        touched, blocked = int(labels[label, _TOUCHED]), int(labels[label, _BLOCKED])
        labels = with_room(labels, count + 1)
        heap = with_room(heap, size + 2)
        if leg == last_leg and vertex == targets[leg]:
            key = arrival + penalty * (touched + tail[until])
            push(heap, size, key << 24, label, 1)
            size += 1
        to_go = hops[leg, vertex]
        if until < num_layers and until + to_go <= window.last:
            own = touched + _more(table[vertex, until], blocked)
            interval = _interval_from(vertex, until, table)
            if _enter(vertex, leg, interval, until, own, label, table, heads, labels, count):
                push(heap, size, ((until + to_go + penalty * own) << 24) + to_go, count, 0)
                size += 1
                count += 1
        for place in range(leaving.offsets[vertex], leaving.offsets[vertex + 1]):
            move = leaving.moves[place]
            other = leaving.ends[move]
            if not free[move]:
                continue
            next_leg = leg
            while next_leg < last_leg and other == targets[next_leg]:
                next_leg += 1
            to_go = hops[next_leg, other]
            if to_go >= UNREACHABLE:
                continue
            # At most one of each for every layer.
            labels = with_room(labels, count + num_layers + 1)
            heap = with_room(heap, size + num_layers + 1)
            latest = min(until, num_layers - 1, window.last - 1 - to_go)
            count, size = _walk(
                move, (other, next_leg, to_go), label, latest, table, penalty, heads, labels, heap,
                count, size,
            )  # fmt: skip
    counts[0], counts[1] = count, size
    return -1, labels, heap


@inlined
def _walk(
    move: int, towards: tuple[int, int, int], label: int, latest: int, table: CountArray,
    penalty: int, heads: StateArray, labels: StateArray, heap: IntArray, count: int, size: int,
) -> tuple[int, int]:  # fmt: skip
    """Labels of all intervals that a move reaches from one, leaving up to a layer; the counts after.

    `towards`: the vertex and leg that it leads to, and hops to go from there.
    """
    other, leg, to_go = towards
    blocked, touched = int(labels[label, _BLOCKED]), int(labels[label, _TOUCHED])
    layer = int(labels[label, ARRIVAL])
    interval, least = (-1, -1), 0
    while layer <= latest:
        reached = _interval(other, leg, layer + 1, table, heads, labels)
        if reached[0] != interval[0]:
            interval, least = reached, 1 << 30
        passing, there = table[move, layer], table[other, interval[0]]
        own = _more(passing, blocked) + _more(there, passing)
        if own < least:
            least, total = own, touched + own
            if _enter(other, leg, interval, layer + 1, total, label, table, heads, labels, count):
                key = layer + 1 + to_go + penalty * total
                push(heap, size, (key << 24) + to_go, count, 0)
                size += 1
                count += 1
        # Leaving later is of use to touch fewer rods, or to reach the next interval there.
        layer += 1
        if least <= _more(there, blocked):
            layer = max(layer, interval[1] - 1)
    return count, size


@inlined
def _interval_from(vertex: int, first: int, table: CountArray) -> tuple[int, int]:
    """The interval of a vertex that begins at an instant."""
    last = first + 1
    while last < table.shape[1] and table[vertex, last] == table[vertex, first]:
        last += 1
    return first, last
