"""Compiled distances of rods and walls; exact between knots."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.smooth_distance.segments import squared_distance


@kernel
def rod_distance(first: FloatArray, second: FloatArray, limit: float) -> float:
    """Distance of two rods (n, 3), (m, 3) in (x, y, c t) with rising time, `limit` if larger; m.

    Both are walked once in time: only segments whose times come within the limit are compared.
    """
    least = limit * limit
    begin = 0
    for i in range(len(first) - 1):
        while begin < len(second) - 2 and second[begin + 1, 2] < first[i, 2] - limit:
            begin += 1
        j = begin
        while j < len(second) - 1 and second[j, 2] <= first[i + 1, 2] + limit:
            gap = squared_distance(
                first[i, 0], first[i, 1], first[i, 2],
                first[i + 1, 0], first[i + 1, 1], first[i + 1, 2],
                second[j, 0], second[j, 1], second[j, 2],
                second[j + 1, 0], second[j + 1, 1], second[j + 1, 2],
            )  # fmt: skip
            least = min(least, gap)
            j += 1
    return float(np.sqrt(least))


@kernel
def segment_distances(positions: FloatArray, segments: IntArray, pairs: IntArray) -> FloatArray:
    """(N,) distances of the pairs (N, 2) of segments (S, 2) between positions (P, 3); m."""
    result = np.empty(len(pairs))
    for k in range(len(pairs)):
        p, q = positions[segments[pairs[k, 0], 0]], positions[segments[pairs[k, 0], 1]]
        u, v = positions[segments[pairs[k, 1], 0]], positions[segments[pairs[k, 1], 1]]
        gap = squared_distance(
            p[0], p[1], p[2], q[0], q[1], q[2], u[0], u[1], u[2], v[0], v[1], v[2]
        )
        result[k] = np.sqrt(gap)
    return result


@kernel
def least_wall_distance(
    starts: FloatArray, ends: FloatArray, segment: IntArray, edge: IntArray, edges: FloatArray
) -> float:
    """Least plane distance over the pairs (segment, edge), inf without any; m."""
    least = np.inf
    for k in range(len(segment)):
        i = segment[k]
        e = edge[k]
        gap = squared_distance(
            starts[i, 0], starts[i, 1], 0.0, ends[i, 0], ends[i, 1], 0.0,
            edges[e, 0], edges[e, 1], 0.0, edges[e, 2], edges[e, 3], 0.0,
        )  # fmt: skip
        least = min(least, gap)
    return float(np.sqrt(least))
