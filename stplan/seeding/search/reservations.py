"""Reservations: which moves at which time layers would touch the rods that are already fixed.

A rod blocks a move during one interval of layers: shifting one of two straight segments in time,
the shifts at which they are too close form an interval (the distance is convex in it). So a rod is
a short list of (move, first layer, last layer), found once by exact segment distances and then
added to or removed from a table of counts in well under a millisecond.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.segments import squared_distance
from stplan.seeding.search.graph import Graph

CountArray = NDArray[np.uint16]
BlockArray = NDArray[np.int32]

# All tables together stay below this many bytes.
MEMORY_LIMIT = 500_000_000
# Moves exactly as far as required are blocked, whatever the rounding.
TOUCHING = 1.0 + 4e-9


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
        self.tables: list[CountArray] = [
            np.zeros((graph.num_moves, grid.count), dtype=np.uint16) for _ in range(num_classes)
        ]
        self._found: BlockArray = np.empty((1 << 16, 3), dtype=np.int32)
        # Rods are cut to pieces no longer than an edge, so that few cells are searched for each.
        self._piece = max(graph.longest_edge, graph.buckets.size)

    def blocks(self, rod: FloatArray, distance: float) -> BlockArray:
        """(n, 3) of (move, first, last layer) nearer than `distance` to `rod` (k, 3), all in m."""
        buckets = self.graph.buckets
        num_vertices = self.graph.num_vertices
        while True:
            count = _find_blocks(
                rod, distance * TOUCHING, self.grid.time_scale * self.grid.begin, self.grid.height,
                self.grid.count, self._piece, self.graph.vertices, self.graph.edges,
                self.graph.length[num_vertices:], self.graph.longest_edge / 2,
                buckets.corner, buckets.size, buckets.shape, buckets.offsets, buckets.items,
                self._found,
            )  # fmt: skip
            if count >= 0:
                return self._found[:count].copy()
            self._found = np.empty((4 * len(self._found), 3), dtype=np.int32)

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


@kernel
def _find_blocks(
    rod: FloatArray,
    distance: float,
    base: float,
    height: float,
    num_layers: int,
    piece: float,
    vertices: FloatArray,
    edges: IntArray,
    walked_length: FloatArray,
    longest_half: float,
    corner: FloatArray,
    cell: float,
    shape: IntArray,
    offsets: IntArray,
    items: IntArray,
    found: BlockArray,
) -> int:
    """Fill `found` with all blocked moves of all segments; their number, or -1 if it is full."""
    num_vertices = len(vertices)
    num_edges = len(edges)
    count = 0
    for segment in range(len(rod) - 1):
        plane = np.hypot(
            rod[segment + 1, 0] - rod[segment, 0], rod[segment + 1, 1] - rod[segment, 1]
        )
        parts = max(1, int(np.ceil(plane / piece - 1e-9)))
        for part in range(parts):
            near = part / parts
            far = (part + 1) / parts
            x0 = rod[segment, 0] + near * (rod[segment + 1, 0] - rod[segment, 0])
            y0 = rod[segment, 1] + near * (rod[segment + 1, 1] - rod[segment, 1])
            z0 = rod[segment, 2] + near * (rod[segment + 1, 2] - rod[segment, 2]) - base
            x1 = rod[segment, 0] + far * (rod[segment + 1, 0] - rod[segment, 0])
            y1 = rod[segment, 1] + far * (rod[segment + 1, 1] - rod[segment, 1])
            z1 = rod[segment, 2] + far * (rod[segment + 1, 2] - rod[segment, 2]) - base
            first = max(int(np.floor((z0 - distance) / height)), 0)
            last = min(int(np.floor((z1 + distance) / height)), num_layers - 1)
            if first > last:
                continue
            mx = (x0 + x1) / 2
            my = (y0 + y1) / 2
            own = plane / parts / 2
            reach = distance + own + longest_half
            left = max(int(np.floor((mx - reach - corner[0]) / cell)), 0)
            right = min(int(np.floor((mx + reach - corner[0]) / cell)), shape[0] - 1)
            bottom = max(int(np.floor((my - reach - corner[1]) / cell)), 0)
            top = min(int(np.floor((my + reach - corner[1]) / cell)), shape[1] - 1)
            for column in range(left, right + 1):
                row_start = offsets[column * shape[1] + bottom] if bottom <= top else 0
                row_end = offsets[column * shape[1] + top + 1] if bottom <= top else 0
                for place in range(row_start, row_end):
                    item = items[place]
                    if item < num_vertices:
                        u = item
                        v = item
                        half = 0.0
                    else:
                        u = edges[item - num_vertices, 0]
                        v = edges[item - num_vertices, 1]
                        half = walked_length[item - num_vertices] / 2
                    ux, uy = vertices[u, 0], vertices[u, 1]
                    vx, vy = vertices[v, 0], vertices[v, 1]
                    dx = (ux + vx) / 2 - mx
                    dy = (uy + vy) / 2 - my
                    span = distance + own + half
                    if dx * dx + dy * dy > span * span:
                        continue
                    plane_squared = squared_distance(
                        ux, uy, 0.0, vx, vy, 0.0, x0, y0, 0.0, x1, y1, 0.0
                    )
                    if plane_squared > distance * distance:
                        continue
                    for way in range(1 if u == v else 2):
                        if way == 1:
                            ux, uy, vx, vy = vx, vy, ux, uy
                        low = first
                        while low <= last and (
                            squared_distance(
                                ux, uy, low * height, vx, vy, (low + 1) * height,
                                x0, y0, z0, x1, y1, z1,
                            )
                            > distance * distance
                        ):  # fmt: skip
                            low += 1
                        if low > last:
                            continue
                        high = last
                        while high > low and (
                            squared_distance(
                                ux, uy, high * height, vx, vy, (high + 1) * height,
                                x0, y0, z0, x1, y1, z1,
                            )
                            > distance * distance
                        ):  # fmt: skip
                            high -= 1
                        if count >= len(found):
                            return -1
                        found[count, 0] = item + way * num_edges
                        found[count, 1] = low
                        found[count, 2] = high
                        count += 1
    return count
