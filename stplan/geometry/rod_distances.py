"""Compiled distances of rods and walls; exact between knots."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.segments import squared_distance


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


def grid_arrays(
    walls: BoundaryGrid,
) -> tuple[FloatArray, FloatArray, float, IntArray, IntArray, IntArray]:
    """What the kernels below take of a grid: edges, origin, cell, shape, starts, members."""
    return walls.edges, walls.origin, walls.cell, walls.shape, walls.starts, walls.members


@kernel
def least_wall_distances(
    heads: FloatArray,
    tails: FloatArray,
    reach: float,
    edges: FloatArray,
    origin: FloatArray,
    cell: float,
    shape: IntArray,
    starts: IntArray,
    members: IntArray,
) -> FloatArray:
    """(n,) distances of plane segments (n, 2) to the edges of a `BoundaryGrid`, at most `reach`; m."""
    result = np.empty(len(heads))
    for k in range(len(heads)):
        p, q = heads[k], tails[k]
        west = (min(p[0], q[0]) - reach - origin[0]) / cell
        east = (max(p[0], q[0]) + reach - origin[0]) / cell
        south = (min(p[1], q[1]) - reach - origin[1]) / cell
        north = (max(p[1], q[1]) + reach - origin[1]) / cell
        least = reach * reach
        for ix in range(max(int(np.floor(west)), 0), min(int(np.floor(east)), shape[0] - 1) + 1):
            for iy in range(
                max(int(np.floor(south)), 0), min(int(np.floor(north)), shape[1] - 1) + 1
            ):
                place = ix * shape[1] + iy
                for m in range(starts[place], starts[place + 1]):
                    e = edges[members[m]]
                    gap = squared_distance(
                        p[0], p[1], 0.0, q[0], q[1], 0.0, e[0], e[1], 0.0, e[2], e[3], 0.0
                    )
                    least = min(least, gap)
        result[k] = np.sqrt(least)
    return result


@kernel
def clear_of_walls(
    p: FloatArray,
    q: FloatArray,
    gap: float,
    edges: FloatArray,
    origin: FloatArray,
    cell: float,
    shape: IntArray,
    starts: IntArray,
    members: IntArray,
) -> bool:
    """Whether the plane segment p q is further than `gap` (m) from the edges of a `BoundaryGrid`."""
    if gap <= 0.0 or len(edges) == 0:
        return True
    extent = max(abs(q[0] - p[0]), abs(q[1] - p[1]))
    pieces = int(extent / cell) + 1
    for k in range(pieces):
        x0, y0 = p[0] + (q[0] - p[0]) * (k / pieces), p[1] + (q[1] - p[1]) * (k / pieces)
        x1 = p[0] + (q[0] - p[0]) * ((k + 1) / pieces)
        y1 = p[1] + (q[1] - p[1]) * ((k + 1) / pieces)
        west = (min(x0, x1) - gap - origin[0]) / cell
        east = (max(x0, x1) + gap - origin[0]) / cell
        south = (min(y0, y1) - gap - origin[1]) / cell
        north = (max(y0, y1) + gap - origin[1]) / cell
        for ix in range(max(int(np.floor(west)), 0), min(int(np.floor(east)), shape[0] - 1) + 1):
            for iy in range(
                max(int(np.floor(south)), 0), min(int(np.floor(north)), shape[1] - 1) + 1
            ):
                place = ix * shape[1] + iy
                for m in range(starts[place], starts[place + 1]):
                    e = edges[members[m]]
                    if squared_distance(
                        x0, y0, 0.0, x1, y1, 0.0, e[0], e[1], 0.0, e[2], e[3], 0.0
                    ) <= gap * gap:  # fmt: skip
                        return False
    return True


@kernel
def shortest_shortcut(
    way: FloatArray,
    gap: float,
    edges: FloatArray,
    origin: FloatArray,
    cell: float,
    shape: IntArray,
    starts: IntArray,
    members: IntArray,
) -> IntArray:
    """Knots of the shortest polyline over knots of `way` (n, 2), of its pieces and of clear lines.

    Straight lines between knots that are not neighbours keep more than `gap` (m) from the edges of a
    `BoundaryGrid`; of equals the longest are taken, for fewer knots.
    """
    count = len(way)
    least = np.full(count, np.inf)
    least[0] = 0.0
    before = np.zeros(count, np.int64)
    for j in range(1, count):
        for i in range(j):
            length = np.hypot(way[j, 0] - way[i, 0], way[j, 1] - way[i, 1])
            total = least[i] + length
            # The piece itself comes last, so that it is taken only where no line is as short.
            if total < least[j] * (1.0 - 1e-12) and (
                i == j - 1
                or clear_of_walls(way[i], way[j], gap, edges, origin, cell, shape, starts, members)
            ):
                least[j] = total
                before[j] = i
    knots = np.empty(count, np.int64)
    knots[0] = count - 1
    used = 1
    while knots[used - 1] > 0:
        knots[used] = before[knots[used - 1]]
        used += 1
    return knots[:used][::-1].copy()
