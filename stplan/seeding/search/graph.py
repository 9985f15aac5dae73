"""The plane graph that searches run on: vertices, undirected edges and the moves they allow.

A move takes one time layer: waiting at a vertex, or walking an edge in either direction. Moves are
numbered: waits 0..V-1, edges forward V..V+E-1, edges backward V+E..V+2E-1. An item is a vertex or
an undirected edge, numbered 0..V+E-1; both directions of an edge share their distance to anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel

UNREACHABLE = 1 << 29


@dataclass(frozen=True)
class Buckets:
    """Square cells over the plane with the items whose middle lies in them (compressed rows).

    Attributes:
        corner: (2,) lower left corner of the cells (m).
        size: side of a cell (m).
        shape: (2,) number of cells in x and y.
        offsets, items: items of cell ``ix * shape[1] + iy`` are
            ``items[offsets[cell]:offsets[cell + 1]]``.
    """

    corner: FloatArray
    size: float
    shape: IntArray
    offsets: IntArray
    items: IntArray


@dataclass(frozen=True)
class Graph:
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
        buckets: items by place.
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
    buckets: Buckets

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
            _fill_hops(goal, self.in_offsets, self.in_moves, self.move_from, free, hops)
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
        buckets=_make_buckets(middles, float(np.median(walked)) if len(walked) else 1.0),
    )


def _rows(keys: IntArray, num_rows: int) -> tuple[IntArray, IntArray]:
    """Positions of every key 0..num_rows-1 in compressed rows, in rising order."""
    positions = np.argsort(keys, kind="stable").astype(np.int64)
    offsets = np.searchsorted(keys[positions], np.arange(num_rows + 1)).astype(np.int64)
    return offsets, positions


def _make_buckets(middles: FloatArray, size: float) -> Buckets:
    """Buckets of `middles` (n, 2) with cells of about `size` (m), at most four an item."""
    corner = middles.min(axis=0)
    extent = middles.max(axis=0) - corner
    size = max(size, float(np.sqrt(extent[0] * extent[1] / (4.0 * len(middles)))))
    size = max(size, float(extent.max()) / (4.0 * len(middles)), 1e-9)
    shape = (extent / size).astype(np.int64) + 1
    cell = np.minimum(((middles - corner) / size).astype(np.int64), shape - 1)
    offsets, items = _rows(cell[:, 0] * shape[1] + cell[:, 1], int(shape[0] * shape[1]))
    return Buckets(corner, size, shape, offsets, items)


@kernel
def _fill_hops(
    goal: int,
    in_offsets: IntArray,
    in_moves: IntArray,
    move_from: IntArray,
    free: BoolArray,
    hops: IntArray,
) -> None:
    """Breadth-first search backwards from `goal`; `hops` comes filled with UNREACHABLE."""
    queue = np.empty(len(hops), np.int64)
    queue[0] = goal
    hops[goal] = 0
    head = 0
    tail = 1
    while head < tail:
        vertex = queue[head]
        head += 1
        for place in range(in_offsets[vertex], in_offsets[vertex + 1]):
            move = in_moves[place]
            source = move_from[move]
            if free[move] and hops[source] == UNREACHABLE:
                hops[source] = hops[vertex] + 1
                queue[tail] = source
                tail += 1


@kernel
def shortest_way(
    start: int,
    targets: IntArray,
    hops: IntArray,
    free: BoolArray,
    out_offsets: IntArray,
    out_moves: IntArray,
    move_to: IntArray,
) -> IntArray:
    """Vertices of one way of fewest hops through `targets` (P,); `hops` (P, V) are still to go."""
    last = len(targets) - 1
    way = np.empty(hops[0, start] + 1, np.int64)
    way[0] = start
    vertex = start
    leg = 0
    for step in range(1, len(way)):
        while leg < last and vertex == targets[leg]:
            leg += 1
        for place in range(out_offsets[vertex], out_offsets[vertex + 1]):
            move = out_moves[place]
            if free[move] and hops[leg, move_to[move]] < hops[leg, vertex]:
                vertex = move_to[move]
                break
        way[step] = vertex
    return way
