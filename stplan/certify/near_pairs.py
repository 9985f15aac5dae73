"""Pairs of agents that may come near each other, found without looking at all pairs.

Time is cut into slabs in which agents move about as far as they are wide. In every slab each agent is in a
box around its motion, grown by half of what a pair is asked to keep; boxes are put into the cells of a grid
that they overlap, and two of them that share a cell and overlap are a pair. None is left out: at an instant
at which two agents are nearer than asked, their boxes of that slab overlap. At constant density the work
grows with the number of agents.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inner, kernel
from stplan.problem.world_lines import WorldLines

# Slabs at most: further ones would cost more than their smaller boxes save.
MOST_SLABS = 1000
# Cells that boxes take on average at most; larger cells are chosen where it would be more.
MOST_CELLS = 16
# Segments shorter than this share of all the time count as so long when slabs are chosen.
SHORTEST = 1e-9
# Multipliers that spread cells over buckets: large primes.
_SPREAD_X, _SPREAD_Y, _SPREAD = 73856093, 19349663, 83492791


def near_pairs(
    lines: WorldLines,
    leaves: FloatArray,
    wanted: BoolArray,
    halves: FloatArray,
    rounding: float = 0.0,
) -> IntArray:
    """(P, 2) pairs a < b, sorted: all wanted ones that come nearer than `halves` allow, and some more.

    Args:
        leaves: (A,) until when each agent is present, s; it stands still after its last knot.
        wanted: (A, A), symmetric.
        halves: (A,) m; a pair is near within the sum of both.
        rounding: by how much computed positions may be off, m.
    """
    starts = np.ascontiguousarray(lines.knots[lines.offsets[:-1], 2])
    codes = _search(
        lines.knots, lines.offsets, starts, leaves, np.argsort(starts, kind="stable"),
        _slabs(lines, starts, leaves, halves), wanted, halves + rounding,
    )  # fmt: skip
    codes = np.sort(codes[codes >= 0])
    return np.column_stack([codes // lines.num_agents, codes % lines.num_agents])


def _slabs(
    lines: WorldLines, starts: FloatArray, leaves: FloatArray, halves: FloatArray
) -> FloatArray:
    """(K + 1,) times between which an agent moves, on average, as far as the mean box is wide."""
    begin, end = float(starts.min()), float(leaves.max())
    is_last = np.zeros(len(lines.knots), dtype=bool)
    is_last[lines.offsets[1:] - 1] = True
    first = np.flatnonzero(~is_last)
    step = lines.knots[first + 1] - lines.knots[first]
    # Jumps would be so fast that sums of speeds lose all others.
    speed = np.hypot(step[:, 0], step[:, 1]) / np.maximum(step[:, 2], SHORTEST * (end - begin))
    still = np.zeros(2 * len(starts))
    there = np.ones(len(starts))
    times = np.concatenate([lines.knots[first, 2], lines.knots[first + 1, 2], starts, leaves])
    faster = np.concatenate([speed, -speed, still])
    more = np.concatenate([np.zeros(2 * len(first)), there, -there])
    order = np.argsort(times, kind="stable")
    mean_speed = np.cumsum(faster[order]) / np.maximum(np.cumsum(more[order]), 1.0)
    moved = np.maximum(mean_speed[:-1], 0.0) * np.diff(times[order])
    progress = np.concatenate([[0.0], np.cumsum(moved)])
    count = int(np.clip(np.ceil(progress[-1] / (2.0 * halves.mean())), 1, MOST_SLABS))
    cuts = np.interp(np.linspace(0.0, progress[-1], count + 1)[1:-1], progress, times[order])
    return np.unique(np.concatenate([[begin], np.clip(cuts, begin, end), [end]]))


@kernel
def _search(
    knots: FloatArray,
    offsets: IntArray,
    starts: FloatArray,
    leaves: FloatArray,
    order: IntArray,
    slabs: FloatArray,
    wanted: BoolArray,
    halves: FloatArray,
) -> IntArray:
    """Codes a A + b of pairs, in a hash table whose free places hold -1; `order` sorts `starts`."""
    count = len(starts)
    segment = offsets[:-1].copy()
    present = np.empty(count, dtype=np.int64)
    boxes = np.empty((count, 4))
    table = np.full(1024, -1, dtype=np.int64)
    used = 0
    coming = 0
    here = 0
    for k in range(max(len(slabs) - 1, 1)):
        begin, end = slabs[k], slabs[min(k + 1, len(slabs) - 1)]
        kept = 0
        for i in range(here):
            if leaves[present[i]] >= begin:
                present[kept] = present[i]
                kept += 1
        here = kept
        while coming < count and starts[order[coming]] <= end:
            present[here] = order[coming]
            here += 1
            coming += 1
        for i in range(here):
            a = present[i]
            segment[a] = _box(
                knots[: offsets[a + 1]], segment[a], max(begin, starts[a]), min(end, leaves[a]),
                halves[a], boxes[i],
            )  # fmt: skip
        table, used = _collect(present[:here], boxes[:here], wanted, table, used)
    return table


@inner
def _box(
    knots: FloatArray, segment: int, begin: float, end: float, half: float, box: FloatArray
) -> int:
    """Fill the `box` of an agent's motion from `begin` to `end`, and return its segment at `begin`."""
    last = len(knots) - 1
    while segment < last and knots[segment + 1, 2] <= begin:
        segment += 1
    box[0] = box[1] = np.inf
    box[2] = box[3] = -np.inf
    k = segment
    for time in (begin, end):
        while k < last and knots[k + 1, 2] <= time:
            k += 1
            _grow(box, knots[k, 0], knots[k, 1])
        if k == last:
            _grow(box, knots[last, 0], knots[last, 1])
        else:
            part = (time - knots[k, 2]) / (knots[k + 1, 2] - knots[k, 2])
            _grow(
                box,
                knots[k, 0] + part * (knots[k + 1, 0] - knots[k, 0]),
                knots[k, 1] + part * (knots[k + 1, 1] - knots[k, 1]),
            )
    box[0] -= half
    box[1] -= half
    box[2] += half
    box[3] += half
    return segment


@inner
def _grow(box: FloatArray, x: float, y: float) -> None:
    box[0], box[1] = min(box[0], x), min(box[1], y)
    box[2], box[3] = max(box[2], x), max(box[3], y)


@inner
def _collect(
    agents: IntArray, boxes: FloatArray, wanted: BoolArray, table: IntArray, used: int
) -> tuple[IntArray, int]:
    """Add the wanted pairs whose boxes overlap."""
    if len(agents) < 2:
        return table, used
    cells, total = _cells(boxes)
    buckets = 1
    while buckets < total:
        buckets *= 2
    # The entries of bucket i are begins[i]:begins[i + 1] of members, after a counting sort.
    begins = np.zeros(buckets + 2, dtype=np.int64)
    for i in range(len(agents)):
        for x in range(cells[i, 0], cells[i, 2] + 1):
            for y in range(cells[i, 1], cells[i, 3] + 1):
                begins[_bucket(x, y, buckets) + 2] += 1
    begins = np.cumsum(begins)
    members = np.empty((total, 3), dtype=np.int64)
    for i in range(len(agents)):
        for x in range(cells[i, 0], cells[i, 2] + 1):
            for y in range(cells[i, 1], cells[i, 3] + 1):
                place = begins[_bucket(x, y, buckets) + 1]
                begins[_bucket(x, y, buckets) + 1] += 1
                members[place, 0], members[place, 1], members[place, 2] = i, x, y
    for bucket in range(buckets):
        for p in range(begins[bucket], begins[bucket + 1]):
            i, x, y = members[p, 0], members[p, 1], members[p, 2]
            for q in range(p + 1, begins[bucket + 1]):
                j = members[q, 0]
                # Of the cells that two boxes share, the lowest counts.
                if (
                    x != max(cells[i, 0], cells[j, 0])
                    or y != max(cells[i, 1], cells[j, 1])
                    or members[q, 1] != x
                    or members[q, 2] != y
                    or boxes[i, 0] > boxes[j, 2]
                    or boxes[j, 0] > boxes[i, 2]
                    or boxes[i, 1] > boxes[j, 3]
                    or boxes[j, 1] > boxes[i, 3]
                ):
                    continue
                a, b = min(agents[i], agents[j]), max(agents[i], agents[j])
                if wanted[a, b]:
                    table, used = _insert(table, used, a * len(wanted) + b)
    return table, used


@inner
def _cells(boxes: FloatArray) -> tuple[IntArray, int]:
    """The cells (first x, first y, last x, last y) that every box overlaps, and how many in all."""
    size = 0.0
    for i in range(len(boxes)):
        size += max(boxes[i, 2] - boxes[i, 0], boxes[i, 3] - boxes[i, 1]) / len(boxes)
    cells = np.empty(boxes.shape, dtype=np.int64)
    while True:
        total = 0.0
        for i in range(len(boxes)):
            for x in range(4):
                cells[i, x] = np.floor(boxes[i, x] / size)
            total += (cells[i, 2] - cells[i, 0] + 1.0) * (cells[i, 3] - cells[i, 1] + 1.0)
        if total <= MOST_CELLS * len(boxes):
            return cells, int(total)
        size *= 2.0


@inner
def _bucket(x: int, y: int, buckets: int) -> int:
    return ((x * _SPREAD_X) ^ (y * _SPREAD_Y)) & (buckets - 1)


@inner
def _insert(table: IntArray, used: int, code: int) -> tuple[IntArray, int]:
    """Put `code` into the table unless it is there; the table is kept at most half full."""
    if 2 * used >= len(table):
        larger = np.full(2 * len(table), -1, dtype=np.int64)
        for old in table:
            if old >= 0:
                larger[_free(larger, old)] = old
        table = larger
    place = _free(table, code)
    if table[place] != code:
        table[place] = code
        used += 1
    return table, used


@inner
def _free(table: IntArray, code: int) -> int:
    """Where `code` is in the table, or where it goes."""
    mask = len(table) - 1
    place = (code * _SPREAD) & mask
    while table[place] >= 0 and table[place] != code:
        place = (place + 1) & mask
    return place
