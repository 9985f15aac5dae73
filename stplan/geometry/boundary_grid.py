"""Broad phase against walls: a fixed grid over the boundary edges, asked for those near a segment."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.grid import Grid, cells_of_box, make_cells, make_grid, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.sorting import sorted_pairs


class BoundaryGrid(NamedTuple):
    """E boundary edges and the grid that they lie in.

    Attributes:
        edges: (E, 4) as x0, y0, x1, y1, m.
        grid: of the edges' bounding boxes in the plane.
    """

    edges: FloatArray
    grid: Grid

    @staticmethod
    def from_segments(segments: FloatArray) -> BoundaryGrid:
        """The grid of boundary edges (E, 4), perhaps none, as x0, y0, x1, y1 in m."""
        edges = np.ascontiguousarray(segments, dtype=np.float64).reshape(-1, 4)
        low = np.minimum(edges[:, :2], edges[:, 2:])
        high = np.maximum(edges[:, :2], edges[:, 2:])
        corners = np.vstack([low, high]) if len(edges) else np.zeros((1, 2))
        # Cells never get smaller than a typical edge; about one cell an edge keeps memory linear.
        typical = float(np.median((high - low).max(axis=1))) if len(edges) else 1.0
        most = 4.0 * len(edges) + 64.0
        cells = make_cells(corners.min(axis=0), corners.max(axis=0), typical, most)
        return BoundaryGrid(edges, make_grid(cells, low, high))

    def near(self, starts: FloatArray, ends: FloatArray, reach: FloatArray) -> IntArray:
        """Pairs (N, 2) of segment and edge whose bounding boxes come within `reach` (S,) m, sorted.

        `starts` and `ends` are (S, 2). Every edge nearer than the reach is among them.
        """
        return _near(
            np.minimum(starts, ends) - reach[:, None],
            np.maximum(starts, ends) + reach[:, None],
            self,
        )


@kernel
def _near(low: FloatArray, high: FloatArray, walls: BoundaryGrid) -> IntArray:
    """Pairs (N, 2) of box and edge that touch, sorted; boxes are `low` to `high` (S, 2), m."""
    edges, grid = walls.edges, walls.grid
    query = make_query(grid.cells)
    seen = np.empty(len(edges), np.int64)
    for e in range(len(edges)):
        seen[e] = -1
    found = np.empty((4 * len(low) + 64, 2), np.int64)
    count = 0
    for k in range(len(low)):
        for x in range(2):
            query.low[x] = low[k, x]
            query.high[x] = high[k, x]
        for r in range(cells_of_box(grid.cells, query)):
            begin, past = grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]
            found = with_room(found, count + past - begin)
            for m in range(begin, past):
                e = grid.members[m]
                if (
                    seen[e] == k
                    or min(edges[e, 0], edges[e, 2]) > high[k, 0]
                    or max(edges[e, 0], edges[e, 2]) < low[k, 0]
                    or min(edges[e, 1], edges[e, 3]) > high[k, 1]
                    or max(edges[e, 1], edges[e, 3]) < low[k, 1]
                ):
                    continue
                seen[e] = k
                found[count, 0] = k
                found[count, 1] = e
                count += 1
    return sorted_pairs(found[:count], max(len(low), len(edges)))
