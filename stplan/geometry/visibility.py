"""Which nodes of a visibility graph see each other: those whose edge a shortest way could take.

A shortest way around rounded corners is made of straight edges that touch an arc at both ends. Where arcs are
replaced by the chords between a few nodes on them, an edge leaves a node within half a chord's turn of the
tangent there, which rules out nearly all pairs before any wall is asked.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.grid import make_query
from stplan.geometry.growable import with_room
from stplan.geometry.wall_distances import clear_of_walls


@kernel
def clear_segments(
    heads: FloatArray, tails: FloatArray, gap: float, walls: BoundaryGrid
) -> BoolArray:
    """(n,) which plane segments (n, 2) are further than `gap` (m) from the walls all the way."""
    query = make_query(walls.grid.cells)
    result = np.empty(len(heads), dtype=np.bool_)
    for k in range(len(heads)):
        result[k] = clear_of_walls(heads[k], tails[k], gap, walls, query)
    return result


@kernel
def tangent_edges(
    nodes: FloatArray,
    normals: FloatArray,
    slack: FloatArray,
    first: int,
    gap: float,
    walls: BoundaryGrid,
) -> IntArray:
    """Pairs (E, 2) i < j of nodes that see each other along an edge that touches both their arcs.

    Args:
        nodes: (N, 2) m; those before `first` lie on no arc and are not joined to one another.
        normals: (N, 2) of the arcs.
        slack: (N,) greatest |sine| of an edge's angle to the tangent; 1 on no arc.
        gap: that edges keep from the walls, m.
    """
    query = make_query(walls.grid.cells)
    found = np.empty((4 * len(nodes) + 64, 2), np.int64)
    count = 0
    for j in range(first, len(nodes)):
        for i in range(j):
            x, y = nodes[j, 0] - nodes[i, 0], nodes[j, 1] - nodes[i, 1]
            length = np.sqrt(x * x + y * y)
            if abs(x * normals[j, 0] + y * normals[j, 1]) > slack[j] * length:
                continue
            if abs(x * normals[i, 0] + y * normals[i, 1]) > slack[i] * length:
                continue
            if clear_of_walls(nodes[i], nodes[j], gap, walls, query):
                found = with_room(found, count + 1)
                found[count, 0] = i
                found[count, 1] = j
                count += 1
    return found[:count]
