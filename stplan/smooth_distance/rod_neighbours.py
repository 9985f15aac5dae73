"""Broad phase: which segments of different agents' rods come near each other in space-time.

A cell list: segments are cut into pieces no longer than a cell, every piece is kept in the cell of
its middle, and only the cells around are compared, so the work grows linearly with the number of
segments at constant density. The answer is exact and sorted, whatever the cell size.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.smooth_distance.segments import squared_distance


def near_segments(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    collides: BoolArray,
    reach: FloatArray,
) -> IntArray:
    """Pairs of segments of colliding agents nearer than the pair's reach.

    Args:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        collides: (A, A) which pairs are asked for.
        reach: (A, A) in m.

    Returns:
        (N, 2) indices i, j of segments with agents[i] < agents[j], sorted.
    """
    if not collides.any():
        return np.empty((0, 2), dtype=np.int64)
    furthest = float(reach[collides].max())
    start = positions[segments[:, 0]]
    end = positions[segments[:, 1]]
    length = np.sqrt(((end - start) ** 2).sum(axis=1))
    piece = max(furthest, float(np.median(length)), 1e-9)
    pieces = np.maximum(np.ceil(length / piece), 1).astype(np.int64)
    owner = np.repeat(np.arange(len(segments)), pieces)
    order = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    middle = start[owner] + (end - start)[owner] * ((order + 0.5) / pieces[owner])[:, None]
    cell = np.floor((middle - middle.min(axis=0)) / (piece + furthest)).astype(np.int64) + 1
    extent = cell.max(axis=0) + 2
    key = (cell[:, 0] * extent[1] + cell[:, 1]) * extent[2] + cell[:, 2]
    sequence = np.argsort(key, kind="stable")
    capacity = 32 * len(segments) + 1024
    while True:
        found = np.empty((capacity, 2), dtype=np.int64)
        count = _collect(
            positions, segments, agents, collides, reach, owner[sequence], key[sequence],
            np.array([extent[1] * extent[2], extent[2], 1]), found,
        )  # fmt: skip
        if count <= capacity:
            break
        capacity = int(1.2 * count)
    codes = np.unique(found[:count, 0] * len(segments) + found[:count, 1])
    return np.column_stack([codes // len(segments), codes % len(segments)])


@kernel
def _collect(
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    collides: BoolArray,
    reach: FloatArray,
    owner: IntArray,
    key: IntArray,
    stride: IntArray,
    found: IntArray,
) -> int:
    """Fill `found` with near pairs (possibly repeated) and return how many there are."""
    count = 0
    last_hit = np.full(len(segments), -1)
    for a in range(len(owner)):
        i = owner[a]
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                base = key[a] + dx * stride[0] + dy * stride[1]
                # Cells along the last axis are neighbours in the sorted keys.
                b = np.searchsorted(key, base - 1)
                while b < len(key) and key[b] <= base + 1:
                    j = owner[b]
                    b += 1
                    p = agents[i]
                    q = agents[j]
                    if p >= q or not collides[p, q] or last_hit[j] == i:
                        continue
                    limit = reach[p, q]
                    if _apart(positions, segments[i], segments[j], limit):
                        continue
                    u0 = positions[segments[i, 0]]
                    u1 = positions[segments[i, 1]]
                    v0 = positions[segments[j, 0]]
                    v1 = positions[segments[j, 1]]
                    if squared_distance(
                        u0[0], u0[1], u0[2], u1[0], u1[1], u1[2],
                        v0[0], v0[1], v0[2], v1[0], v1[1], v1[2],
                    ) < limit * limit:  # fmt: skip
                        last_hit[j] = i
                        if count < len(found):
                            found[count, 0] = i
                            found[count, 1] = j
                        count += 1
    return count


@kernel
def _apart(positions: FloatArray, first: IntArray, second: IntArray, limit: float) -> bool:
    """Whether the bounding boxes of two segments are further apart than `limit` along an axis."""
    for x in range(3):
        a0 = positions[first[0], x]
        a1 = positions[first[1], x]
        b0 = positions[second[0], x]
        b1 = positions[second[1], x]
        if min(a0, a1) - limit > max(b0, b1) or max(a0, a1) + limit < min(b0, b1):
            return True
    return False
