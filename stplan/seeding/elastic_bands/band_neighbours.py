"""Which segments of different elastic bands are near each other in space-time, as compressed rows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.grid import Grid, cells_of_box, make_cells, make_grid, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.segments import space_time_point, squared_distance
from stplan.geometry.sorting import counting_sort

# Cells of the grid for every segment, at most; larger cells are used where this would not do.
CELLS_PER_SEGMENT = 8


class Neighbours(NamedTuple):
    """What is near every segment, in compressed rows.

    Attributes:
        rows: (S + 1,) and
        members: what is near segment s is ``members[rows[s]:rows[s + 1]]``.
    """

    rows: IntArray
    members: IntArray


class Boxes(NamedTuple):
    """Segments with their bounding boxes.

    Attributes:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        asking: (S,) segments that ask; the others are only asked about.
        low, high: (S, 3) corners, m.
    """

    positions: FloatArray
    segments: IntArray
    agents: IntArray
    asking: BoolArray
    low: FloatArray
    high: FloatArray


def near_rows(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    asking: BoolArray,
    collides: BoolArray,
    reach: FloatArray,
    cell: float,
) -> Neighbours:
    """Segments nearer than their pair's reach, for every segment that asks.

    The work grows linearly with the number of segments at constant density.

    Args:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        asking: (S,) segments that ask; the others are only asked about.
        collides: (A, A) which pairs count.
        reach: (A, A) in m.
        cell: wanted side of a cell (m).
    """
    heads, tails = positions[segments[:, 0]], positions[segments[:, 1]]
    low, high = np.minimum(heads, tails), np.maximum(heads, tails)
    most = CELLS_PER_SEGMENT * len(segments) + 64
    grid = make_grid(make_cells(low.min(axis=0), high.max(axis=0), cell, most), low, high)
    boxes = Boxes(positions, segments, agents, asking, low, high)
    return Neighbours(*_near_rows(boxes, grid, collides, reach))


@kernel
def _near_rows(
    boxes: Boxes, grid: Grid, collides: BoolArray, reach: FloatArray
) -> tuple[IntArray, IntArray]:
    """Rows and members of the near segments."""
    positions, segments, agents, asking, low, high = boxes
    widest = np.empty(len(reach))
    for a in range(len(reach)):
        widest[a] = 0.0
        for b in range(len(reach)):
            if collides[a, b]:
                widest[a] = max(widest[a], reach[a, b])
    query = make_query(grid.cells)
    seen = np.empty(len(segments), np.int64)
    for i in range(len(segments)):
        seen[i] = -1
    # Both ways round, as far as they ask.
    near = np.empty((16 * len(segments) + 64, 2), np.int64)
    count = 0
    for i in range(len(segments)):
        a = agents[i]
        if not asking[i] or widest[a] == 0.0:
            continue
        p = space_time_point(positions, segments[i, 0])
        q = space_time_point(positions, segments[i, 1])
        for x in range(3):
            query.low[x] = low[i, x] - widest[a]
            query.high[x] = high[i, x] + widest[a]
        for r in range(cells_of_box(grid.cells, query)):
            begin, past = grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]
            near = with_room(near, count + 2 * (past - begin))
            for k in range(begin, past):
                j = grid.members[k]
                b = agents[j]
                # A pair that both ask for is found from the first of them.
                if seen[j] == i or (j <= i and asking[j]) or not collides[a, b]:
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
                u = space_time_point(positions, segments[j, 0])
                v = space_time_point(positions, segments[j, 1])
                if squared_distance(p, q, u, v) < limit * limit:
                    near[count, 0] = i
                    near[count, 1] = j
                    count += 1
                    if asking[j]:
                        near[count, 0] = j
                        near[count, 1] = i
                        count += 1
    rows, members = counting_sort(near[:count], len(segments))
    for k in range(count):
        members[k] = near[members[k], 1]
    return rows, members


@kernel
def tight_pairs(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    near: Neighbours,
    required: FloatArray,
) -> IntArray:
    """(N, 2) pairs of agents with segments no further apart than required, repeated as they come.

    A pair of agents that both ask appears in both orders.
    """
    found = np.empty((64, 2), np.int64)
    count = 0
    for i in range(len(segments)):
        found = with_room(found, count + near.rows[i + 1] - near.rows[i])
        for k in range(near.rows[i], near.rows[i + 1]):
            j = near.members[k]
            limit = required[agents[i], agents[j]]
            gap = squared_distance(
                space_time_point(positions, segments[i, 0]),
                space_time_point(positions, segments[i, 1]),
                space_time_point(positions, segments[j, 0]),
                space_time_point(positions, segments[j, 1]),
            )
            if gap <= limit * limit:
                found[count, 0] = agents[i]
                found[count, 1] = agents[j]
                count += 1
    return found[:count]
