"""Reservations: which moves at which time layers would touch the rods that are already fixed.

A rod blocks a move during one interval of layers: shifting one of two straight segments in time,
the shifts at which they are too close form an interval (the distance is convex in it). So a rod is
a short list of (move, first layer, last layer), found once by exact segment distances and then
added to or removed from a table of counts in well under a millisecond.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import FloatArray
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.grid import Grid, cells_of_box, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.segments import Point, plane_point, space_time_point, squared_distance
from stplan.seeding.search.graph import Graph

CountArray = NDArray[np.uint16]
BlockArray = NDArray[np.int32]

# All tables together stay below this many bytes.
MEMORY_LIMIT = 500_000_000
# Moves exactly as far as required are blocked, whatever the rounding.
TOUCHING = 1.0 + 4e-9
# Room for so many blocks at first.
FIRST_BLOCKS = 4096


@dataclass(frozen=True)
class TimeGrid:
    """Layers of time: layer l is the instant ``begin + l * step`` (s), l = 0..count.

    A move of layer l lasts from instant l to instant l + 1.
    """

    begin: float
    step: float
    count: int
    time_scale: float

    @property
    def height(self) -> float:
        """c times the step: how high a layer is in space-time (m)."""
        return self.time_scale * self.step

    def instant(self, layer: int) -> float:
        """Time of `layer` in s."""
        return self.begin + layer * self.step


class Reservations:
    """Counts of the rods that block each move, one table a class of agents.

    Attributes:
        tables: K arrays (M, L): by how many rods a move of a layer is blocked for a class.
    """

    def __init__(self, graph: Graph, grid: TimeGrid, num_classes: int) -> None:
        self.graph = graph
        self.grid = grid
        num_items = graph.num_vertices + len(graph.edges)
        self._items = Items(
            graph.vertices[graph.move_from[:num_items]],
            graph.vertices[graph.move_to[:num_items]],
            graph.length[:num_items] / 2,
            graph.longest_edge,
            graph.num_vertices,
            graph.middles,
        )
        self._layers = Layers(grid.time_scale * grid.begin, grid.height, grid.count)
        self.tables: list[CountArray] = [
            np.zeros((graph.num_moves, grid.count), dtype=np.uint16) for _ in range(num_classes)
        ]

    def blocks(self, rod: FloatArray, distance: float) -> BlockArray:
        """(n, 3) of (move, first, last layer) nearer than `distance` to `rod` (k, 3), all in m."""
        return _find_blocks(rod, distance * TOUCHING, self._layers, self._items).copy()

    def add(self, class_index: int, blocks: BlockArray) -> None:
        """Count `blocks` once more for a class."""
        _change(self.tables[class_index], blocks, 1)

    def remove(self, class_index: int, blocks: BlockArray) -> None:
        """Take back an `add` of the same blocks."""
        _change(self.tables[class_index], blocks, -1)

    def clear(self) -> None:
        """Forget every rod."""
        for table in self.tables:
            table[:] = 0


def table_bytes(graph: Graph, num_layers: int) -> int:
    """Size in bytes of the table of one class."""
    return 2 * graph.num_moves * num_layers


@kernel
def _change(table: CountArray, blocks: BlockArray, by: int) -> None:
    """Add `by` to all blocked (move, layer) of `blocks`."""
    for index in range(len(blocks)):
        move = blocks[index, 0]
        for layer in range(blocks[index, 1], blocks[index, 2] + 1):
            table[move, layer] = np.uint16(np.int64(table[move, layer]) + by)


class Layers(NamedTuple):
    """Layers of time as heights.

    Attributes:
        base: c times the instant of layer 0, m.
        height: c times the step, m.
        total: how many there are.
    """

    base: float
    height: float
    total: int


class Items(NamedTuple):
    """What a rod may block: the items of a graph, its V vertices and its E edges.

    Attributes:
        heads, tails: (V + E, 2) ends, m.
        halves: (V + E,) half of their lengths, m.
        longest: of the edges, m.
        num_vertices: V.
        middles: grid of their middles.
    """

    heads: FloatArray
    tails: FloatArray
    halves: FloatArray
    longest: float
    num_vertices: int
    middles: Grid


@kernel
def _find_blocks(rod: FloatArray, distance: float, layers: Layers, items: Items) -> BlockArray:
    """(n, 3) blocked moves of all segments of a rod, with their first and last layers."""
    middles = items.middles
    query = make_query(middles.cells)
    # Rods are cut to pieces no longer than an edge, so that few cells are searched for each.
    longest = max(items.longest, middles.cells.size)
    limit = distance * distance
    num_edges = len(items.heads) - items.num_vertices
    found = np.empty((FIRST_BLOCKS, 3), np.int32)
    count = 0
    for segment in range(len(rod) - 1):
        head, tail = space_time_point(rod, segment), space_time_point(rod, segment + 1)
        plane = np.hypot(tail[0] - head[0], tail[1] - head[1])
        parts = max(1, int(np.ceil(plane / longest - 1e-9)))
        own = plane / parts / 2
        for part in range(parts):
            p = _point_between(head, tail, part / parts, layers.base)
            q = _point_between(head, tail, (part + 1) / parts, layers.base)
            first = max(int(np.floor((p[2] - distance) / layers.height)), 0)
            last = min(int(np.floor((q[2] + distance) / layers.height)), layers.total - 1)
            if first > last:
                continue
            mx, my = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2
            reach = distance + own + items.longest / 2
            query.low[0], query.high[0] = mx - reach, mx + reach
            query.low[1], query.high[1] = my - reach, my + reach
            for r in range(cells_of_box(middles.cells, query)):
                begin, past = middles.starts[query.runs[r, 0]], middles.starts[query.runs[r, 1]]
                found = with_room(found, count + 2 * (past - begin))
                for place in range(begin, past):
                    item = middles.members[place]
                    u, v = plane_point(items.heads, item), plane_point(items.tails, item)
                    dx, dy = (u[0] + v[0]) / 2 - mx, (u[1] + v[1]) / 2 - my
                    span = distance + own + items.halves[item]
                    if dx * dx + dy * dy > span * span:
                        continue
                    if squared_distance(u, v, (p[0], p[1]), (q[0], q[1])) > limit:
                        continue
                    for way in range(1 if item < items.num_vertices else 2):
                        if way == 1:
                            u, v = v, u
                        low = first
                        while low <= last and _squared_gap(u, v, low, layers, p, q) > limit:
                            low += 1
                        if low > last:
                            continue
                        high = last
                        while high > low and _squared_gap(u, v, high, layers, p, q) > limit:
                            high -= 1
                        found[count, 0] = item + way * num_edges
                        found[count, 1] = low
                        found[count, 2] = high
                        count += 1
    return found[:count]


@inlined
def _point_between(head: Point, tail: Point, part: float, base: float) -> Point:
    """The point at a part of the way from `head` to `tail`, heights from `base` on."""
    return (
        head[0] + part * (tail[0] - head[0]),
        head[1] + part * (tail[1] - head[1]),
        head[2] + part * (tail[2] - head[2]) - base,
    )


@inner
def _squared_gap(u: Point, v: Point, layer: int, layers: Layers, p: Point, q: Point) -> float:
    """Squared distance of the move from u to v in a layer to the segment p q, m^2."""
    low, high = layer * layers.height, (layer + 1) * layers.height
    return squared_distance((u[0], u[1], low), (v[0], v[1], high), p, q)
