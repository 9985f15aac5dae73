"""Which segments of different strings are near each other in space-time, as compressed rows.

A uniform grid over (x, y, c t): a segment lies in every cell its bounding box touches, and asks the
cells that its box, widened by the reach, touches. At constant density the work grows linearly.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.segments import squared_distance

# Cells of the grid for every segment, at most; larger cells are used where this would not do.
CELLS_PER_SEGMENT = 8


@kernel
def near_rows(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    movable: BoolArray,
    collides: BoolArray,
    reach: FloatArray,
    cell: float,
) -> tuple[IntArray, IntArray]:
    """Segments nearer than their pair's reach, for every segment of a movable agent.

    Args:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        movable: (S,) segments that ask; the others are only asked about.
        collides: (A, A) which pairs count.
        reach: (A, A) in m.
        cell: wanted side of a cell (m).

    Returns:
        offsets (S + 1,) and members: segment s is near members[offsets[s]:offsets[s + 1]].
    """
    num_segments = len(segments)
    low, high = _boxes(positions, segments)
    origin = np.empty(3)
    shape = np.empty(3, np.int64)
    size = cell
    for x in range(3):
        origin[x] = low[:, x].min()
    while True:
        count = 1.0
        for x in range(3):
            shape[x] = int((high[:, x].max() - origin[x]) / size) + 1
            count *= shape[x]
        if count <= CELLS_PER_SEGMENT * num_segments + 64:
            break
        size *= 1.26
    starts, contents = _fill(low, high, origin, size, shape)
    widest = np.zeros(len(reach))
    for a in range(len(reach)):
        for b in range(len(reach)):
            if collides[a, b]:
                widest[a] = max(widest[a], reach[a, b])
    pairs = np.empty((8 * num_segments + 64, 2), np.int64)
    seen = np.full(num_segments, -1)
    first = np.empty(3, np.int64)
    last = np.empty(3, np.int64)
    total = 0
    for i in range(num_segments):
        a = agents[i]
        if not movable[i] or widest[a] == 0.0:
            continue
        p = segments[i, 0]
        q = segments[i, 1]
        for x in range(3):
            first[x] = max(int(np.floor((low[i, x] - widest[a] - origin[x]) / size)), 0)
            last[x] = min(int((high[i, x] + widest[a] - origin[x]) / size), shape[x] - 1)
        for ix in range(first[0], last[0] + 1):
            for iy in range(first[1], last[1] + 1):
                row = (ix * shape[1] + iy) * shape[2]
                # Cells along time lie side by side: one run of contents.
                for k in range(starts[row + first[2]], starts[row + last[2] + 1]):
                    j = contents[k]
                    b = agents[j]
                    # A pair that both ask for is found from the first of them.
                    if seen[j] == i or (j <= i and movable[j]) or not collides[a, b]:
                        continue
                    seen[j] = i
                    limit = reach[a, b]
                    if (
                        low[j, 0] > high[i, 0] + limit
                        or high[j, 0] < low[i, 0] - limit
                        or low[j, 1] > high[i, 1] + limit
                        or high[j, 1] < low[i, 1] - limit
                        or low[j, 2] > high[i, 2] + limit
                        or high[j, 2] < low[i, 2] - limit
                    ):
                        continue
                    u = segments[j, 0]
                    v = segments[j, 1]
                    gap = squared_distance(
                        positions[p, 0], positions[p, 1], positions[p, 2],
                        positions[q, 0], positions[q, 1], positions[q, 2],
                        positions[u, 0], positions[u, 1], positions[u, 2],
                        positions[v, 0], positions[v, 1], positions[v, 2],
                    )  # fmt: skip
                    if gap < limit * limit:
                        if total == len(pairs):
                            longer = np.empty((2 * total, 2), np.int64)
                            longer[:total] = pairs
                            pairs = longer
                        pairs[total, 0] = i
                        pairs[total, 1] = j
                        total += 1
    return _rows(pairs[:total], movable)


@kernel
def _rows(pairs: IntArray, movable: BoolArray) -> tuple[IntArray, IntArray]:
    """Compressed rows of both segments of every pair, as far as they ask."""
    offsets = np.zeros(len(movable) + 1, np.int64)
    for k in range(len(pairs)):
        for x in range(2):
            if movable[pairs[k, x]]:
                offsets[pairs[k, x] + 1] += 1
    for i in range(len(movable)):
        offsets[i + 1] += offsets[i]
    cursor = offsets[:-1].copy()
    members = np.empty(offsets[-1], np.int64)
    for k in range(len(pairs)):
        for x in range(2):
            i = pairs[k, x]
            if movable[i]:
                members[cursor[i]] = pairs[k, 1 - x]
                cursor[i] += 1
    return offsets, members


@kernel
def _boxes(positions: FloatArray, segments: IntArray) -> tuple[FloatArray, FloatArray]:
    """Bounding boxes (S, 3), (S, 3) of the segments."""
    low = np.empty((len(segments), 3))
    high = np.empty((len(segments), 3))
    for i in range(len(segments)):
        for x in range(3):
            u = positions[segments[i, 0], x]
            v = positions[segments[i, 1], x]
            low[i, x] = min(u, v)
            high[i, x] = max(u, v)
    return low, high


@kernel
def _fill(
    low: FloatArray, high: FloatArray, origin: FloatArray, size: float, shape: IntArray
) -> tuple[IntArray, IntArray]:
    """Cells as compressed rows of the segments whose boxes touch them."""
    starts = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    contents = np.empty(0, np.int64)
    cursor = starts
    for turn in range(2):
        if turn == 1:
            for k in range(len(starts) - 1):
                starts[k + 1] += starts[k]
            contents = np.empty(starts[-1], np.int64)
            cursor = starts.copy()
        for i in range(len(low)):
            for ix in range(
                int((low[i, 0] - origin[0]) / size), int((high[i, 0] - origin[0]) / size) + 1
            ):
                for iy in range(
                    int((low[i, 1] - origin[1]) / size), int((high[i, 1] - origin[1]) / size) + 1
                ):
                    row = (ix * shape[1] + iy) * shape[2]
                    for iz in range(
                        int((low[i, 2] - origin[2]) / size),
                        int((high[i, 2] - origin[2]) / size) + 1,
                    ):
                        if turn == 0:
                            starts[row + iz + 1] += 1
                        else:
                            contents[cursor[row + iz]] = i
                            cursor[row + iz] += 1
    return starts, contents


@kernel
def tight_pairs(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    rows: IntArray,
    members: IntArray,
    required: FloatArray,
) -> IntArray:
    """(N, 2) pairs of agents with segments no further apart than required, repeated as they come.

    A pair of movable agents appears in both orders.
    """
    found = np.empty((64, 2), np.int64)
    count = 0
    for i in range(len(segments)):
        for k in range(rows[i], rows[i + 1]):
            j = members[k]
            limit = required[agents[i], agents[j]]
            p, q = positions[segments[i, 0]], positions[segments[i, 1]]
            u, v = positions[segments[j, 0]], positions[segments[j, 1]]
            gap = squared_distance(
                p[0], p[1], p[2], q[0], q[1], q[2], u[0], u[1], u[2], v[0], v[1], v[2]
            )
            if gap > limit * limit:
                continue
            if count == len(found):
                longer = np.empty((2 * count, 2), np.int64)
                longer[:count] = found
                found = longer
            found[count, 0] = agents[i]
            found[count, 1] = agents[j]
            count += 1
    return found[:count]
