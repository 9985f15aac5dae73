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
from stplan.geometry.grid import Grid, grid_of_boxes

UNREACHABLE = 1 << 29


class MoveRows(NamedTuple):
    """Moves of every vertex, waits left out, in compressed rows.

    Attributes:
        offsets: (V + 1,) and
        moves: (2 E,) those of vertex v are ``moves[offsets[v]:offsets[v + 1]]``, rising.
        ends: (V + 2 E,) the vertex at the other end of every move, waits included.
    """

    offsets: IntArray
    moves: IntArray
    ends: IntArray


class Graph(NamedTuple):
    """A plane graph with clearances.

    Attributes:
        vertices: (V, 2) in m.
        edges: (E, 2) vertex indices, each pair once.
        clearance: (V + E,) distance of every item to the walls (m), inf in the open plane, below 0
            outside of the free space.
        move_from, move_to: (V + 2 E,) vertices of every move.
        length: (V + 2 E,) plane length of every move (m).
        leaving, entering: moves that leave and enter every vertex.
        middles: grid of the middles of all items in the plane.
    """

    vertices: FloatArray
    edges: IntArray
    clearance: FloatArray
    move_from: IntArray
    move_to: IntArray
    length: FloatArray
    leaving: MoveRows
    entering: MoveRows
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
            _fill_hops(goal, self.entering, free, hops)
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
        leaving=_rows(move_from, move_to, num_vertices),
        entering=_rows(move_to, move_from, num_vertices),
        middles=_grid_of_points(middles, float(np.median(walked)) if len(walked) else 1.0),
    )


def _rows(vertices: IntArray, ends: IntArray, num_vertices: int) -> MoveRows:
    """The moves of each of their `vertices`, with their other `ends`; the first are waits."""
    keys = vertices[num_vertices:]
    moves = np.argsort(keys, kind="stable").astype(np.int64)
    offsets = np.searchsorted(keys[moves], np.arange(num_vertices + 1)).astype(np.int64)
    return MoveRows(offsets, moves + num_vertices, ends)


def _grid_of_points(points: FloatArray, size: float) -> Grid:
    """The grid of `points` (n, 2) with cells of about `size` (m), at most four a point."""
    return grid_of_boxes(points, points, size, 4.0 * len(points))


@kernel
def _fill_hops(goal: int, entering: MoveRows, free: BoolArray, hops: IntArray) -> None:
    """Breadth-first search backwards from `goal`; `hops` comes filled with UNREACHABLE."""
    queue = np.empty(len(hops), np.int64)
    queue[0] = goal
    hops[goal] = 0
    head = 0
    tail = 1
    while head < tail:
        vertex = queue[head]
        head += 1
        for place in range(entering.offsets[vertex], entering.offsets[vertex + 1]):
            move = entering.moves[place]
            source = entering.ends[move]
            if free[move] and hops[source] == UNREACHABLE:
                hops[source] = hops[vertex] + 1
                queue[tail] = source
                tail += 1
