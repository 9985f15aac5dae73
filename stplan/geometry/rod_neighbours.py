"""Broad phase: which segments of different agents' rods come near each other in space-time.

A cell list: segments are cut into pieces no longer than twice the reach, every piece is kept in the cell
of its middle, and only the cells around are compared, so the work grows linearly with the number of
segments at constant density. The answer is exact and sorted, whatever the cell size.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.segments import squared_distance

# Pieces this many reaches long keep the number of comparisons least: with pieces of length p, a
# neighbourhood holds about (p + reach)^3 / p of them, and there are 1 / p to ask.
PIECE = 2.0
# Most cells for every piece: a grid of a sparse scene is made coarser rather than larger.
CELLS_A_PIECE = 8


def near_segments(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    collides: BoolArray,
    reach: FloatArray,
    asked: BoolArray | None = None,
) -> IntArray:
    """Pairs of segments of colliding agents nearer than the pair's reach.

    Args:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        collides: (A, A) which pairs are asked for.
        reach: (A, A) in m.
        asked: (S,) only pairs with one of these segments, all by default.

    Returns:
        (N, 2) indices i, j of segments with agents[i] < agents[j], sorted unless `asked`.
    """
    if not collides.any():
        return np.empty((0, 2), dtype=np.int64)
    furthest = float(reach[collides].max())
    start = np.ascontiguousarray(positions[segments[:, 0]])
    end = np.ascontiguousarray(positions[segments[:, 1]])
    length = np.sqrt(((end - start) ** 2).sum(axis=1))
    # A scene of hardly any reach is not cut finer than its segments ask for.
    piece = max(PIECE * furthest, 0.1 * float(np.median(length)), 1e-9)
    pieces = np.maximum(np.ceil(length / piece), 1).astype(np.int64)
    low = np.minimum(start, end).min(axis=0)
    extent = np.maximum(start, end).max(axis=0) - low
    cell = piece + furthest
    while np.prod(np.floor(extent / cell) + 1.0) > CELLS_A_PIECE * pieces.sum() + 1024:
        cell *= 1.5
    shape = np.floor(extent / cell).astype(np.int64) + 1
    everyone = asked is None
    if asked is None:
        asked = np.ones(len(segments), dtype=bool)
    capacity = 32 * len(segments) + 1024
    while True:
        found = np.empty((capacity, 2), dtype=np.int64)
        count = _collect(
            start, end, length, pieces, agents, collides, reach, asked, everyone, low, cell,
            shape, found,
        )  # fmt: skip
        if count <= capacity:
            return found[:count].copy()
        capacity = int(1.2 * count)


@kernel
def _collect(
    start: FloatArray,
    end: FloatArray,
    length: FloatArray,
    pieces: IntArray,
    agents: IntArray,
    collides: BoolArray,
    reach: FloatArray,
    asked: BoolArray,
    everyone: bool,
    low: FloatArray,
    cell: float,
    shape: IntArray,
    found: IntArray,
) -> int:
    """Fill `found` with near pairs and return how many there are, more than fit if need be."""
    middles, places, firsts = _sorted_pieces(start, end, pieces, low, cell, shape)
    owners = agents[places]
    count = 0
    last_hit = np.full(len(start), -1)
    for i in range(len(start)):
        if not asked[i]:
            continue
        p = agents[i]
        row = count
        for k in range(pieces[i]):
            share = (k + 0.5) / pieces[i]
            x = start[i, 0] + share * (end[i, 0] - start[i, 0])
            y = start[i, 1] + share * (end[i, 1] - start[i, 1])
            z = start[i, 2] + share * (end[i, 2] - start[i, 2])
            cx, cy, cz = (
                int((x - low[0]) / cell),
                int((y - low[1]) / cell),
                int((z - low[2]) / cell),
            )
            for nx in range(max(cx - 1, 0), min(cx + 2, shape[0])):
                for ny in range(max(cy - 1, 0), min(cy + 2, shape[1])):
                    # Cells along the last axis follow one another.
                    column = (nx * shape[1] + ny) * shape[2]
                    first = firsts[column + max(cz - 1, 0)]
                    past = firsts[column + min(cz + 1, shape[2] - 1) + 1]
                    for b in range(first, past):
                        dx, dy, dz = x - middles[b, 0], y - middles[b, 1], z - middles[b, 2]
                        if dx * dx + dy * dy + dz * dz > cell * cell:
                            continue
                        q = owners[b]
                        j = places[b]
                        # Two that are asked for find each other once, from the lower agent.
                        if p == q or (p > q and (everyone or asked[j])):
                            continue
                        if not collides[p, q] or last_hit[j] == i:
                            continue
                        limit = reach[p, q]
                        room = limit + 0.5 * (length[i] / pieces[i] + length[j] / pieces[j])
                        if dx * dx + dy * dy + dz * dz > room * room:
                            continue
                        if squared_distance(
                            start[i, 0], start[i, 1], start[i, 2], end[i, 0], end[i, 1], end[i, 2],
                            start[j, 0], start[j, 1], start[j, 2], end[j, 0], end[j, 1], end[j, 2],
                        ) < limit * limit:  # fmt: skip
                            last_hit[j] = i
                            if count < len(found):
                                found[count, 0] = i if p < q else j
                                found[count, 1] = j if p < q else i
                            count += 1
        if everyone and count <= len(found):
            found[row:count, 1] = np.sort(found[row:count, 1])
    return count


@kernel
def _sorted_pieces(
    start: FloatArray,
    end: FloatArray,
    pieces: IntArray,
    low: FloatArray,
    cell: float,
    shape: IntArray,
) -> tuple[FloatArray, IntArray, IntArray]:
    """Middles (P, 3) and segments (P,) of all pieces by cell, and where every cell begins."""
    total = int(pieces.sum())
    keys = np.empty(total, dtype=np.int64)
    middles = np.empty((total, 3))
    segments = np.empty(total, dtype=np.int64)
    firsts = np.zeros(int(shape[0] * shape[1] * shape[2]) + 1, dtype=np.int64)
    at = 0
    for i in range(len(start)):
        for k in range(pieces[i]):
            share = (k + 0.5) / pieces[i]
            key = 0
            for axis in range(3):
                middle = start[i, axis] + share * (end[i, axis] - start[i, axis])
                middles[at, axis] = middle
                key = key * shape[axis] + int((middle - low[axis]) / cell)
            keys[at] = key
            segments[at] = i
            firsts[key + 1] += 1
            at += 1
    for key in range(len(firsts) - 1):
        firsts[key + 1] += firsts[key]
    filled = firsts[:-1].copy()
    sorted_middles = np.empty_like(middles)
    sorted_segments = np.empty_like(segments)
    for at in range(total):
        place = filled[keys[at]]
        filled[keys[at]] += 1
        sorted_middles[place] = middles[at]
        sorted_segments[place] = segments[at]
    return sorted_middles, sorted_segments, firsts
