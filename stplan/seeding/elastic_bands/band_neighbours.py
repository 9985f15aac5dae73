"""Which segments of different elastic bands are near each other in space-time, as compressed rows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.geometry.allocation import new_integer_rows, new_integers, new_number_rows
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.grid import cells_of_box, fill, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.segments import closest_of_segments
from stplan.geometry.sorting import counting_sort
from stplan.threads import shares, together

# Work with the first of many segments over that with the last one.
FIRST_WORK = 4.6
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


class Bodies(NamedTuple):
    """Segments that may be near each other.

    Attributes:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        asking: (S,) segments that ask; the others are only asked about.
    """

    positions: FloatArray
    segments: IntArray
    agents: IntArray
    asking: BoolArray


def widest_reach(collides: BoolArray, reach: FloatArray) -> FloatArray:
    """(A,) the furthest `reach` (A, A) of every agent, m; -inf of those that collide with nobody."""
    return np.asarray(reach.max(axis=1, where=collides, initial=-np.inf))


def near_rows(
    bodies: Bodies,
    collides: BoolArray,
    reach: FloatArray,
    cell: float,
    *,
    skin: float = 0.0,
    widest: FloatArray | None = None,
) -> Neighbours:
    """Segments nearer than their pair's reach and the skin, for every segment that asks.

    The work grows linearly with the number of segments at constant density.

    Args:
        collides: (A, A) which pairs count.
        reach: (A, A) in m.
        cell: wanted side of a cell (m).
        skin: m.
        widest: the `widest_reach` of `reach`, where it is known.
    """
    widest = widest_reach(collides, reach) if widest is None else widest
    # The work is with those that ask, and most of it with the first ones: they find the others.
    work = bodies.asking * np.linspace(FIRST_WORK, 1.0, len(bodies.asking))
    found = together(
        _near_segments,
        [(bodies, collides, reach, skin, widest, cell, *share) for share in shares(work)],
    )
    near = found[0] if len(found) == 1 else np.vstack(found)
    return Neighbours(*_by_row(near, len(bodies.segments)))


def near_edges(
    walls: BoundaryGrid, heads: FloatArray, tails: FloatArray, reach: FloatArray
) -> Neighbours:
    """Boundary edges within `reach` (S,) m of segments between `heads` and `tails` (S, 3)."""
    near = walls.near(heads, tails, reach)
    rows = np.searchsorted(near[:, 0], np.arange(len(heads) + 1)).astype(np.int64)
    return Neighbours(rows, np.ascontiguousarray(near[:, 1]))


@kernel
def _near_segments(
    bodies: Bodies,
    collides: BoolArray,
    reach: FloatArray,
    skin: float,
    widest: FloatArray,
    cell: float,
    head: int,
    tail: int,
) -> IntArray:
    """(N, 2) segments that ask and what is near, found from segments `head` to `tail`."""
    positions, segments, agents, asking = bodies
    low, high = _boxes(positions, segments)
    # Side by side, the corners of a box come from memory together.
    boxes = new_number_rows(len(segments), 6)
    for i in range(len(segments)):
        for x in range(3):
            boxes[i, x] = low[i, x]
            boxes[i, 3 + x] = high[i, x]
    grid = fill(low, high, cell, CELLS_PER_SEGMENT * len(segments) + 64.0)
    query = make_query(grid.cells)
    seen = new_integers(len(segments))
    for i in range(len(segments)):
        seen[i] = -1
    # Both ways round, as far as they ask.
    near = new_integer_rows(16 * len(segments) + 64, 2)
    count = 0
    for i in range(head, tail):
        a = agents[i]
        furthest = widest[a] + skin
        if not asking[i] or furthest <= 0.0:
            continue
        for x in range(3):
            query.low[x] = low[i, x] - furthest
            query.high[x] = high[i, x] + furthest
        for r in range(cells_of_box(grid.cells, query)):
            begin, past = grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]
            near = with_room(near, count + 2 * (past - begin))
            for k in range(begin, past):
                j = grid.members[k]
                # A pair that both ask for is found from the first of them. What is far away in memory is
                # asked about the few that may be near only: boxes of others, and squares of all pairs.
                if (j <= i and asking[j]) or _apart(boxes, i, j, furthest) or seen[j] == i:
                    continue
                seen[j] = i
                b = agents[j]
                if not collides[a, b]:
                    continue
                limit = reach[a, b] + skin
                if _apart(boxes, i, j, limit):
                    continue
                if closest_of_segments(positions, segments, i, j)[2] < limit * limit:
                    near[count, 0] = i
                    near[count, 1] = j
                    count += 1
                    if asking[j]:
                        near[count, 0] = j
                        near[count, 1] = i
                        count += 1
    return near[:count]


@inlined
def _apart(boxes: FloatArray, i: int, j: int, limit: float) -> bool:
    """Whether two of `boxes` (S, 6) are further than `limit` apart along an axis."""
    return (
        boxes[j, 0] > boxes[i, 3] + limit
        or boxes[j, 3] < boxes[i, 0] - limit
        or boxes[j, 1] > boxes[i, 4] + limit
        or boxes[j, 4] < boxes[i, 1] - limit
        or boxes[j, 2] > boxes[i, 5] + limit
        or boxes[j, 5] < boxes[i, 2] - limit
    )


@kernel
def _by_row(near: IntArray, num_segments: int) -> tuple[IntArray, IntArray]:
    """Rows and members of the (N, 2) segments that ask and what is near."""
    rows, members = counting_sort(near, num_segments)
    for k in range(len(near)):
        members[k] = near[members[k], 1]
    return rows, members


@inlined
def _boxes(positions: FloatArray, segments: IntArray) -> tuple[FloatArray, FloatArray]:
    """Bounding boxes (S, 3), (S, 3) of the segments."""
    low = new_number_rows(len(segments), 3)
    high = new_number_rows(len(segments), 3)
    for i in range(len(segments)):
        u, v = segments[i, 0], segments[i, 1]
        for x in range(3):
            low[i, x] = min(positions[u, x], positions[v, x])
            high[i, x] = max(positions[u, x], positions[v, x])
    return low, high


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

    `rows` and `members` are those of `Neighbours`. A pair of agents that both ask appears in both orders.
    """
    found = new_integer_rows(64, 2)
    count = 0
    for i in range(len(segments)):
        found = with_room(found, count + rows[i + 1] - rows[i])
        for k in range(rows[i], rows[i + 1]):
            j = members[k]
            limit = required[agents[i], agents[j]]
            if closest_of_segments(positions, segments, i, j)[2] <= limit * limit:
                found[count, 0] = agents[i]
                found[count, 1] = agents[j]
                count += 1
    return found[:count]
