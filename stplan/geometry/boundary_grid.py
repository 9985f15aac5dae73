"""Broad phase against walls: a fixed grid over the boundary edges, asked for those near a segment."""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel


class BoundaryGrid:
    """Uniform grid over E boundary edges ``boundary_segments`` (E, 4) as x0, y0, x1, y1 in m."""

    def __init__(self, boundary_segments: FloatArray) -> None:
        self.edges = np.ascontiguousarray(boundary_segments, dtype=np.float64)
        low = np.minimum(self.edges[:, :2], self.edges[:, 2:])
        high = np.maximum(self.edges[:, :2], self.edges[:, 2:])
        self.origin = low.min(axis=0)
        span = np.maximum(high.max(axis=0) - self.origin, 1e-9)
        # About one cell an edge keeps memory linear; cells never get smaller than a typical edge.
        typical = float(np.median((high - low).max(axis=1)))
        self.cell = max(float(np.sqrt(span.prod() / len(self.edges))), typical, 1e-9)
        self.shape = np.ceil(span / self.cell).astype(np.int64) + 1
        self.starts, self.members = _fill_grid(
            self.edges, self.origin, self.cell, int(self.shape[0]), int(self.shape[1])
        )

    def near(
        self, starts: FloatArray, ends: FloatArray, reach: FloatArray
    ) -> tuple[IntArray, IntArray]:
        """Pairs (segment, edge) whose bounding boxes come within `reach` (S,) m, sorted.

        `starts` and `ends` are (S, 2). Every edge nearer than the reach is among them.
        """
        capacity = 16 * len(starts) + 1024
        while True:
            segment = np.empty(capacity, dtype=np.int64)
            edge = np.empty(capacity, dtype=np.int64)
            count = _query_grid(
                starts, ends, reach, self.edges, self.origin, self.cell,
                int(self.shape[0]), int(self.shape[1]), self.starts, self.members, segment, edge,
            )  # fmt: skip
            if count <= capacity:
                return segment[:count], edge[:count]
            capacity = count


@kernel
def _fill_grid(
    edges: FloatArray, origin: FloatArray, cell: float, columns: int, rows: int
) -> tuple[IntArray, IntArray]:
    """Cells as compressed rows: edges of cell k are members[starts[k]:starts[k + 1]]."""
    starts = np.zeros(columns * rows + 1, dtype=np.int64)
    members = np.empty(0, dtype=np.int64)
    for fill in range(2):
        if fill == 1:
            for k in range(columns * rows):
                starts[k + 1] += starts[k]
            members = np.empty(starts[-1], dtype=np.int64)
            cursor = starts.copy()
        for e in range(len(edges)):
            x0 = (min(edges[e, 0], edges[e, 2]) - origin[0]) / cell
            x1 = (max(edges[e, 0], edges[e, 2]) - origin[0]) / cell
            y0 = (min(edges[e, 1], edges[e, 3]) - origin[1]) / cell
            y1 = (max(edges[e, 1], edges[e, 3]) - origin[1]) / cell
            for i in range(max(int(x0), 0), min(int(x1), columns - 1) + 1):
                for j in range(max(int(y0), 0), min(int(y1), rows - 1) + 1):
                    if fill == 0:
                        starts[i * rows + j + 1] += 1
                    else:
                        members[cursor[i * rows + j]] = e
                        cursor[i * rows + j] += 1
    return starts, members


@kernel
def _query_grid(
    starts: FloatArray,
    ends: FloatArray,
    reach: FloatArray,
    edges: FloatArray,
    origin: FloatArray,
    cell: float,
    columns: int,
    rows: int,
    cell_starts: IntArray,
    members: IntArray,
    segment: IntArray,
    edge: IntArray,
) -> int:
    count = 0
    seen = np.full(len(edges), -1)
    for k in range(len(starts)):
        x0 = min(starts[k, 0], ends[k, 0]) - reach[k]
        x1 = max(starts[k, 0], ends[k, 0]) + reach[k]
        y0 = min(starts[k, 1], ends[k, 1]) - reach[k]
        y1 = max(starts[k, 1], ends[k, 1]) + reach[k]
        first = count
        for i in range(
            max(int(np.floor((x0 - origin[0]) / cell)), 0),
            min(int(np.floor((x1 - origin[0]) / cell)), columns - 1) + 1,
        ):
            for j in range(
                max(int(np.floor((y0 - origin[1]) / cell)), 0),
                min(int(np.floor((y1 - origin[1]) / cell)), rows - 1) + 1,
            ):
                for m in range(cell_starts[i * rows + j], cell_starts[i * rows + j + 1]):
                    e = members[m]
                    if seen[e] == k:
                        continue
                    seen[e] = k
                    if (
                        min(edges[e, 0], edges[e, 2]) > x1
                        or max(edges[e, 0], edges[e, 2]) < x0
                        or min(edges[e, 1], edges[e, 3]) > y1
                        or max(edges[e, 1], edges[e, 3]) < y0
                    ):
                        continue
                    if count < len(segment):
                        segment[count] = k
                        edge[count] = e
                    count += 1
        if count <= len(edge):
            edge[first:count].sort()
    return count


@kernel
def crossings(
    starts: FloatArray, ends: FloatArray, segment: IntArray, edge: IntArray, edges: FloatArray
) -> BoolArray:
    """Which of the pairs (segment, edge) touch or cross, (N,) bool, by orientation of triangles."""
    result = np.zeros(len(segment), dtype=np.bool_)
    for k in range(len(segment)):
        ax, ay = starts[segment[k], 0], starts[segment[k], 1]
        bx, by = ends[segment[k], 0], ends[segment[k], 1]
        px, py = edges[edge[k], 0], edges[edge[k], 1]
        qx, qy = edges[edge[k], 2], edges[edge[k], 3]
        if max(ax, bx) < min(px, qx) or min(ax, bx) > max(px, qx):
            continue
        if max(ay, by) < min(py, qy) or min(ay, by) > max(py, qy):
            continue
        side_p = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
        side_q = (bx - ax) * (qy - ay) - (by - ay) * (qx - ax)
        side_a = (qx - px) * (ay - py) - (qy - py) * (ax - px)
        side_b = (qx - px) * (by - py) - (qy - py) * (bx - px)
        result[k] = side_p * side_q <= 0.0 and side_a * side_b <= 0.0
    return result
