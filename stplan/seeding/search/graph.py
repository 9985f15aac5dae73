"""The plane graph that searches run on: vertices, undirected edges and the moves they allow.

A move takes one time layer: waiting at a vertex, or walking an edge in either direction. Moves are
numbered: waits 0..V-1, edges forward V..V+E-1, edges backward V+E..V+2E-1. An item is a vertex or
an undirected edge, numbered 0..V+E-1; both directions of an edge share their distance to anything.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.grid import Grid, make_cells, make_grid

UNREACHABLE = 1 << 29


class Graph(NamedTuple):
    """A plane graph with clearances.

    Attributes:
        vertices: (V, 2) in m.
        edges: (E, 2) vertex indices, each pair once.
        clearance: (V + E,) distance of every item to the walls (m), inf in the open plane, below 0
            outside of the free space.
        move_from, move_to: (V + 2 E,) vertices of every move.
        length: (V + 2 E,) plane length of every move (m).
        out_offsets, out_moves: moves that leave a vertex, waits left out (compressed rows).
        in_offsets, in_moves: moves that enter a vertex, waits left out.
        middles: grid of the middles of all items in the plane.
    """

    vertices: FloatArray
    edges: IntArray
    clearance: FloatArray
    move_from: IntArray
    move_to: IntArray
    length: FloatArray
    out_offsets: IntArray
    out_moves: IntArray
    in_offsets: IntArray
    in_moves: IntArray
    middles: Grid

    @property
    def num_vertices(self) -> int:
        """Number of vertices V."""
        return len(self.vertices)

    @property
    def num_moves(self) -> int:
        """Number of moves V + 2 E."""
        return len(self.move_from)

    @property
    def longest_edge(self) -> float:
        """Length of the longest edge in m, 0 without edges."""
        return float(self.length.max(initial=0.0))

    def free_moves(self, radius: float) -> BoolArray:
        """(V + 2 E,) moves whose distance to the walls exceeds `radius` (m); -inf frees all."""
        free = self.clearance > radius
        walked = free[self.num_vertices :]
        return np.concatenate([free, walked])

    def hops_to(self, goal: int, free: BoolArray) -> IntArray:
        """(V,) fewest `free` moves from every vertex to `goal`, or UNREACHABLE."""
        hops = np.full(self.num_vertices, UNREACHABLE, dtype=np.int64)
        if free[goal]:
            _fill_hops(goal, self, free, hops)
        return hops


def make_graph(vertices: FloatArray, edges: IntArray, clearance: FloatArray) -> Graph:
    """The graph of `vertices` (V, 2), `edges` (E, 2) and item `clearance` (V + E,)."""
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    edges = np.ascontiguousarray(edges, dtype=np.int64).reshape(-1, 2)
    num_vertices = len(vertices)
    rest = np.arange(num_vertices, dtype=np.int64)
    move_from = np.concatenate([rest, edges[:, 0], edges[:, 1]])
    move_to = np.concatenate([rest, edges[:, 1], edges[:, 0]])
    step = vertices[move_to] - vertices[move_from]
    out_offsets, out_moves = _rows(move_from[num_vertices:], num_vertices)
    in_offsets, in_moves = _rows(move_to[num_vertices:], num_vertices)
    middles = np.concatenate([vertices, (vertices[edges[:, 0]] + vertices[edges[:, 1]]) / 2])
    length = np.hypot(step[:, 0], step[:, 1])
    walked = length[num_vertices:]
    return Graph(
        vertices=vertices,
        edges=edges,
        clearance=np.ascontiguousarray(clearance, dtype=np.float64),
        move_from=move_from,
        move_to=move_to,
        length=length,
        out_offsets=out_offsets,
        out_moves=out_moves + num_vertices,
        in_offsets=in_offsets,
        in_moves=in_moves + num_vertices,
        middles=_grid_of_points(middles, float(np.median(walked)) if len(walked) else 1.0),
    )


def _rows(keys: IntArray, num_rows: int) -> tuple[IntArray, IntArray]:
    """Positions of every key 0..num_rows-1 in compressed rows, in rising order."""
    positions = np.argsort(keys, kind="stable").astype(np.int64)
    offsets = np.searchsorted(keys[positions], np.arange(num_rows + 1)).astype(np.int64)
    return offsets, positions


def _grid_of_points(points: FloatArray, size: float) -> Grid:
    """The grid of `points` (n, 2) with cells of about `size` (m), at most four a point."""
    low, high = points.min(axis=0), points.max(axis=0)
    return make_grid(make_cells(low, high, size, 4.0 * len(points)), points, points)


@kernel
def _fill_hops(goal: int, graph: Graph, free: BoolArray, hops: IntArray) -> None:
    """Breadth-first search backwards from `goal`; `hops` comes filled with UNREACHABLE."""
    queue = np.empty(len(hops), np.int64)
    queue[0] = goal
    hops[goal] = 0
    head = 0
    tail = 1
    while head < tail:
        vertex = queue[head]
        head += 1
        for place in range(graph.in_offsets[vertex], graph.in_offsets[vertex + 1]):
            move = graph.in_moves[place]
            source = graph.move_from[move]
            if free[move] and hops[source] == UNREACHABLE:
                hops[source] = hops[vertex] + 1
                queue[tail] = source
                tail += 1
