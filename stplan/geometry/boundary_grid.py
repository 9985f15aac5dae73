"""Broad phase against walls: a fixed grid over the boundary edges, asked for those near a segment."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.allocation import new_integer_rows, new_integers
from stplan.geometry.grid import Grid, cells_of_box, grid_of_boxes, make_query
from stplan.geometry.growable import with_room
from stplan.geometry.sorting import sorted_pairs

# Cells for every edge, at most.
CELLS_PER_EDGE = 4


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
        """The grid of boundary edges (E, 4), at least one, as x0, y0, x1, y1 in m."""
        edges = np.ascontiguousarray(segments, dtype=np.float64)
        low = np.minimum(edges[:, :2], edges[:, 2:])
        high = np.maximum(edges[:, :2], edges[:, 2:])
        # Cells never get smaller than a typical edge; a few cells an edge keep memory linear.
        typical = float(np.median((high - low).max(axis=1)))
        most = CELLS_PER_EDGE * len(edges) + 64.0
        return BoundaryGrid(edges, grid_of_boxes(low, high, typical, most))

    def near(self, starts: FloatArray, ends: FloatArray, reach: FloatArray) -> IntArray:
        """Pairs (N, 2) of segment and edge whose bounding boxes come within `reach` (S,) m, sorted.

        `starts` and `ends` are (S, 2), or (S, 3) in space-time. Every edge nearer than the reach is
        among them.
        """
        return _near(np.ascontiguousarray(starts), np.ascontiguousarray(ends), reach, self)


@kernel
def _near(starts: FloatArray, ends: FloatArray, reach: FloatArray, walls: BoundaryGrid) -> IntArray:
    """See `BoundaryGrid.near`."""
    edges, grid = walls.edges, walls.grid
    query = make_query(grid.cells)
    low, high = query.low, query.high
    seen = new_integers(len(edges))
    for e in range(len(edges)):
        seen[e] = -1
    found = new_integer_rows(4 * len(starts) + 64, 2)
    count = 0
    for k in range(len(starts)):
        for x in range(2):
            low[x] = min(starts[k, x], ends[k, x]) - reach[k]
            high[x] = max(starts[k, x], ends[k, x]) + reach[k]
        for r in range(cells_of_box(grid.cells, query)):
            begin, past = grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]
            found = with_room(found, count + past - begin)
            for m in range(begin, past):
                e = grid.members[m]
                if (
                    seen[e] == k
                    or min(edges[e, 0], edges[e, 2]) > high[0]
                    or max(edges[e, 0], edges[e, 2]) < low[0]
                    or min(edges[e, 1], edges[e, 3]) > high[1]
                    or max(edges[e, 1], edges[e, 3]) < low[1]
                ):
                    continue
                seen[e] = k
                found[count, 0] = k
                found[count, 1] = e
                count += 1
    return sorted_pairs(found[:count], max(len(starts), len(edges)))
