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

from typing import NamedTuple

import numpy as np

from stplan.arrays import IntArray
from stplan.compiled import inlined, inner, kernel
from stplan.deadline import passed
from stplan.geometry.growable import with_room
from stplan.seeding.search.graph import Graph, MoveRows
from stplan.seeding.search.heap import drop_root, push
from stplan.seeding.search.journey import Journey, Window, leg_at
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

# Columns of a label in place of those for the interval of a state: its interval, and rods run into.
_INTERVAL, _TOUCHED = FIRST, LAST
# Columns of an interval: its first and last instant, rods that block waiting, and its newest label.
_FROM, _TO, _BLOCKED, _LABEL = range(4)


class SoftIntervalSearch:
    """The search on one graph, with its working memory."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self._memory = _Memory(
            np.empty((1 << 12, STATE_COLUMNS), dtype=np.int32),
            np.empty((1 << 12, 4), dtype=np.int32),
            np.empty((1 << 12, 3), dtype=np.int64),
        )

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
        heads = np.full((*journey.hops.shape, 2), -1, np.int32)
        counts = np.zeros(3, np.int64)
        tail = _rods_after(table[journey.targets[-1]], window.stays)
        self._memory = _begin(journey, window, table, heads, self._memory, counts)
        while counts[1] > 0:
            final, self._memory = _search(
                journey, window, self.graph.leaving, table, tail, penalty, heads, self._memory,
                counts, CHUNK,
            )  # fmt: skip
            if final >= 0:
                return way_to(final, window.first, self._memory.labels)
            if passed():
                return None
        return None


class _Memory(NamedTuple):
    """What a search notes down, all of it in arrays that grow.

    Attributes:
        labels: rows of the columns above.
        intervals: of all vertices on all legs that have been reached, those of one beside each other.
        heap: the queue; the last column says whether an entry stands for the whole way.
    """

    labels: StateArray
    intervals: StateArray
    heap: IntArray


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
def _reach(
    vertex: int, leg: int, table: CountArray, heads: StateArray, intervals: StateArray, count: int
) -> int:
    """Enter the intervals of a vertex on a leg unless they are known; how many intervals there are then.

    `heads` (P, V, 2) are the first of them, -1 where they are not known, and the one after the last.
    """
    if heads[leg, vertex, 0] >= 0:
        return count
    heads[leg, vertex, 0] = count
    first, num_layers = 0, table.shape[1]
    for layer in range(1, num_layers + 1):
        if layer == num_layers or table[vertex, layer] != table[vertex, first]:
            intervals[count, _FROM], intervals[count, _TO] = first, layer
            intervals[count, _BLOCKED], intervals[count, _LABEL] = table[vertex, first], -1
            first = layer
            count += 1
    heads[leg, vertex, 1] = count
    return count


@inlined
def _holding(instant: int, low: int, past: int, intervals: StateArray) -> int:
    """The interval from `low` to before `past` that holds an instant, of two the earlier one."""
    while past - low > 1:
        middle = (low + past) >> 1
        if intervals[middle, _FROM] < instant:
            low = middle
        else:
            past = middle
    return low


@inner
def _enter(
    interval: int, place: tuple[int, int], arrival: int, touched: int, parent: int,
    labels: StateArray, intervals: StateArray, count: int,
) -> bool:  # fmt: skip
    """Make a label of an interval of a `place`, vertex and leg, unless there is one as good."""
    label = int(intervals[interval, _LABEL])
    while label >= 0:
        if labels[label, ARRIVAL] <= arrival and labels[label, _TOUCHED] <= touched:
            return False
        label = int(labels[label, NEXT])
    labels[count, VERTEX], labels[count, LEG] = place
    labels[count, _INTERVAL], labels[count, _TOUCHED] = interval, touched
    labels[count, ARRIVAL], labels[count, PARENT] = arrival, parent
    labels[count, NEXT] = intervals[interval, _LABEL]
    intervals[interval, _LABEL] = count
    return True


@inner
def _beaten(label: int, labels: StateArray, intervals: StateArray) -> bool:
    """Whether a later label of the same interval is as good."""
    other = int(intervals[labels[label, _INTERVAL], _LABEL])
    # The newest come first.
    while other > label:
        if (
            labels[other, ARRIVAL] <= labels[label, ARRIVAL]
            and labels[other, _TOUCHED] <= labels[label, _TOUCHED]
        ):
            return True
        other = int(labels[other, NEXT])
    return False


@kernel
def _begin(
    journey: Journey, window: Window, table: CountArray, heads: StateArray, memory: _Memory,
    counts: IntArray,
) -> _Memory:  # fmt: skip
    """Enter the first label, if there is any way from the start.

    `heads` (P, V, 2) come filled with -1; `counts` (3,), of labels, of entries in the queue and of intervals,
    with 0.
    """
    start, targets, hops, free = journey
    begun = leg_at(start, 0, targets)
    if window.first + hops[begun, start] > window.last or not free[start]:
        return memory
    memory = _Memory(memory.labels, with_room(memory.intervals, table.shape[1]), memory.heap)
    counts[2] = _reach(start, begun, table, heads, memory.intervals, 0)
    layer = min(window.first, table.shape[1] - 1)
    interval = _holding(layer + 1, 0, counts[2], memory.intervals)
    touched = int(table[start, layer])
    place = (start, begun)
    _enter(interval, place, window.first, touched, -1, memory.labels, memory.intervals, 0)
    push(memory.heap, 0, 0, 0, 0)
    counts[0] = counts[1] = 1
    return memory


@kernel
def _search(
    journey: Journey, window: Window, leaving: MoveRows, table: CountArray, tail: IntArray,
    penalty: int, heads: StateArray, memory: _Memory, counts: IntArray, most: int,
) -> tuple[int, _Memory]:  # fmt: skip
    """Search on, for at `most` so many labels taken from the queue.

    The label at the goal, -1 if it is not found yet, and the working memory, which may have grown.
    """
    targets, hops, free = journey.targets, journey.hops, journey.free
    num_layers = table.shape[1]
    last_leg = len(targets) - 1
    labels, intervals, heap = memory
    count, size = counts[0], counts[1]
    taken = 0
    while size > 0 and taken < most:
        taken += 1
        label, final = heap[0, 1], heap[0, 2]
        drop_root(heap, size)
        size -= 1
        if final == 1:
            return label, _Memory(labels, intervals, heap)
        if _beaten(label, labels, intervals):
            continue
        vertex, leg = int(labels[label, VERTEX]), int(labels[label, LEG])
        interval, touched = int(labels[label, _INTERVAL]), int(labels[label, _TOUCHED])
        until = int(intervals[interval, _TO])
        labels = with_room(labels, count + 1)
        heap = with_room(heap, size + 2)
        if leg == last_leg and vertex == targets[leg]:
            key = labels[label, ARRIVAL] + penalty * (touched + tail[until])
            push(heap, size, key << 24, label, 1)
            size += 1
        to_go = hops[leg, vertex]
        if until < num_layers and until + to_go <= window.last:
            own = touched + _more(intervals[interval + 1, _BLOCKED], intervals[interval, _BLOCKED])
            if _enter(interval + 1, (vertex, leg), until, own, label, labels, intervals, count):
                push(heap, size, ((until + to_go + penalty * own) << 24) + to_go, count, 0)
                size += 1
                count += 1
        for place in range(leaving.offsets[vertex], leaving.offsets[vertex + 1]):
            move = leaving.moves[place]
            other = leaving.ends[move]
            if not free[move]:
                continue
            next_leg = leg_at(other, leg, targets)
            to_go = hops[next_leg, other]
            latest = min(until, num_layers - 1, window.last - 1 - to_go)
            if latest < labels[label, ARRIVAL]:
                continue
            # At most one of each for every layer.
            labels = with_room(labels, count + num_layers + 1)
            heap = with_room(heap, size + num_layers + 1)
            intervals = with_room(intervals, counts[2] + num_layers)
            counts[2] = _reach(other, next_leg, table, heads, intervals, counts[2])
            count, size = _walk(
                table[move], (other, next_leg, to_go), label, latest, penalty, heads,
                _Memory(labels, intervals, heap), count, size,
            )  # fmt: skip
    counts[0], counts[1] = count, size
    return -1, _Memory(labels, intervals, heap)


@inlined
def _walk(
    passing: CountArray, towards: tuple[int, int, int], label: int, latest: int, penalty: int,
    heads: StateArray, memory: _Memory, count: int, size: int,
) -> tuple[int, int]:  # fmt: skip
    """Labels of all intervals that a move reaches from one, leaving up to a layer; the counts after.

    Args:
        passing: (L,) rods that block the move.
        towards: the vertex and leg that it leads to, and hops to go from there.
    """
    labels, intervals, heap = memory
    other, leg, to_go = towards
    blocked = intervals[labels[label, _INTERVAL], _BLOCKED]
    touched, layer = int(labels[label, _TOUCHED]), int(labels[label, ARRIVAL])
    past = heads[leg, other, 1]
    reached, least = _holding(layer + 1, heads[leg, other, 0], past, intervals), 1 << 30
    while layer <= latest:
        # Of two intervals that meet at an instant it is the freer one.
        while reached + 1 < past and (
            intervals[reached, _TO] <= layer
            or (
                intervals[reached, _TO] == layer + 1
                and intervals[reached + 1, _BLOCKED] < intervals[reached, _BLOCKED]
            )
        ):
            reached, least = reached + 1, 1 << 30
        there = intervals[reached, _BLOCKED]
        own = _more(passing[layer], blocked) + _more(there, passing[layer])
        if own < least:
            least, total = own, touched + own
            if _enter(reached, (other, leg), layer + 1, total, label, labels, intervals, count):
                key = layer + 1 + to_go + penalty * total
                push(heap, size, (key << 24) + to_go, count, 0)
                size += 1
                count += 1
        # Leaving later is of use to touch fewer rods, or to reach the next interval there.
        layer += 1
        if least <= _more(there, blocked):
            layer = max(layer, int(intervals[reached, _TO]) - 1)
    return count, size
