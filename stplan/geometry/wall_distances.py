"""Compiled distances of plane segments to walls, exact between their ends."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.allocation import new_numbers
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.grid import Query, cells_of_box, make_query
from stplan.geometry.segments import Point, plane_point, squared_distance


@inlined
def squared_edge_distance(p: Point, q: Point, edges: FloatArray, edge: int) -> float:
    """Squared distance of the plane segment p q to one of `edges` (E, 4), m^2."""
    return squared_distance(
        p, q, (edges[edge, 0], edges[edge, 1]), (edges[edge, 2], edges[edge, 3])
    )


@kernel
def least_wall_distance(
    starts: FloatArray, ends: FloatArray, pairs: IntArray, edges: FloatArray
) -> float:
    """Least distance over the pairs (N, 2) of segment (S, 2) and edge (E, 4), inf without any; m."""
    least = np.inf
    for k in range(len(pairs)):
        i = pairs[k, 0]
        gap = squared_edge_distance(
            plane_point(starts, i), plane_point(ends, i), edges, pairs[k, 1]
        )
        least = min(least, gap)
    return np.sqrt(least)


@kernel
def least_wall_distances(
    heads: FloatArray, tails: FloatArray, reach: float, walls: BoundaryGrid
) -> FloatArray:
    """(n,) distances of plane segments (n, 2) to the walls, at most `reach`; m."""
    grid = walls.grid
    query = make_query(grid.cells)
    result = new_numbers(len(heads))
    for k in range(len(heads)):
        p, q = plane_point(heads, k), plane_point(tails, k)
        for x in range(2):
            query.low[x] = min(p[x], q[x]) - reach
            query.high[x] = max(p[x], q[x]) + reach
        least = reach * reach
        for r in range(cells_of_box(grid.cells, query)):
            for m in range(grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]):
                least = min(least, squared_edge_distance(p, q, walls.edges, grid.members[m]))
        result[k] = np.sqrt(least)
    return result


@inner
def clear_of_walls(
    p: FloatArray, q: FloatArray, gap: float, walls: BoundaryGrid | None, query: Query | None
) -> bool:
    """Whether the segment p q, in the plane, is further than `gap` (m) from the walls.

    A long segment is cut into pieces no longer than a cell, so that only cells along it are asked.
    `query` is working memory; both are None in the open plane.
    """
    if walls is None or query is None:
        return True
    if gap <= 0.0:
        return True
    grid = walls.grid
    extent = max(abs(q[0] - p[0]), abs(q[1] - p[1]))
    pieces = int(extent / grid.cells.size) + 1
    for k in range(pieces):
        head = (p[0] + (q[0] - p[0]) * (k / pieces), p[1] + (q[1] - p[1]) * (k / pieces))
        part = (k + 1) / pieces
        tail = (p[0] + (q[0] - p[0]) * part, p[1] + (q[1] - p[1]) * part)
        for x in range(2):
            query.low[x] = min(head[x], tail[x]) - gap
            query.high[x] = max(head[x], tail[x]) + gap
        for r in range(cells_of_box(grid.cells, query)):
            for m in range(grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]):
                squared = squared_edge_distance(head, tail, walls.edges, grid.members[m])
                if squared <= gap * gap:
                    return False
    return True
