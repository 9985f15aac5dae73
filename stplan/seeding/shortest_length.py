"""Least length of a way at an agent's radius: a lower bound that proves who must be late.

The free space is eroded by slightly less than the radius, and round corners by chords on the side of
the wall, so the area holds every way there is. Its shortest ways bend at its own reflex corners only:
Dijkstra's algorithm on the graph of corners that see each other is exact.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from stplan.arrays import FloatArray
from stplan.world import FreeSpace, eroded
from stplan.world.placement import EROSION_SAFETY

# With more corners than this only the straight way counts: it is a lower bound as well.
MOST_CORNERS = 400
# Corners see each other along the rim: the area is widened by this part of the radius.
RIM = 1e-6


class ShortestLengths:
    """Least lengths at one radius (m) in a free space, None the open plane."""

    def __init__(self, free_space: FreeSpace | None, radius: float) -> None:
        self.area: shapely.Geometry | None = None
        self.corners = np.empty((0, 2))
        self.lengths = csr_array((0, 0))
        if free_space is None:
            return
        inner = eroded(free_space.polygon, radius * (1.0 - EROSION_SAFETY))
        corners = _reflex_corners(inner)
        if len(corners) > MOST_CORNERS:
            return
        self.area = inner.buffer(RIM * radius)
        shapely.prepare(self.area)
        self.corners = corners
        head, tail = np.triu_indices(len(corners), 1)
        seen = self._sees(corners[head], corners[tail])
        length = np.hypot(*(corners[tail] - corners[head]).T)
        size = len(corners)
        self.lengths = csr_array((length[seen], (head[seen], tail[seen])), shape=(size, size))

    def through(self, stops: FloatArray) -> float:
        """Least length in m of a way through all `stops` (n, 2) in order."""
        return sum(self._between(head, tail) for head, tail in pairwise(stops))

    def _between(self, head: FloatArray, tail: FloatArray) -> float:
        straight = float(np.hypot(*(tail - head)))
        if self.area is None or self._sees(head[None], tail[None])[0]:
            return straight
        size = len(self.corners)
        graph = self.lengths.tocoo()
        rows, columns = [np.asarray(graph.row, np.int64)], [np.asarray(graph.col, np.int64)]
        lengths = [np.asarray(graph.data, np.float64)]
        for index, point in enumerate((head, tail)):
            step = np.hypot(*(self.corners - point).T)
            seen = np.flatnonzero(self._sees(np.broadcast_to(point, (size, 2)), self.corners))
            rows.append(np.full(len(seen), size + index))
            columns.append(seen)
            lengths.append(step[seen])
        whole = csr_array(
            (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))),
            shape=(size + 2, size + 2),
        )
        found = float(dijkstra(whole, directed=False, indices=np.array([size]))[0, size + 1])
        return found if np.isfinite(found) else straight

    def _sees(self, heads: FloatArray, tails: FloatArray) -> FloatArray:
        lines = shapely.linestrings(np.stack([heads, tails], axis=1))
        return np.asarray(shapely.covers(self.area, lines))


def _reflex_corners(area: shapely.Geometry) -> FloatArray:
    """(n, 2) corners of `area` whose inner angle is over 180 degrees."""
    found = []
    for part in shapely.get_parts(area):
        if not isinstance(part, shapely.Polygon) or part.is_empty:
            continue
        for ring in (part.exterior, *part.interiors):
            points = np.asarray(ring.coords, dtype=np.float64)[:-1, :2]
            before, after = (
                points - np.roll(points, 1, axis=0),
                np.roll(points, -1, axis=0) - points,
            )
            turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
            outside = ring is part.exterior
            reflex = turn < 0.0 if ring.is_ccw == outside else turn > 0.0
            found.append(points[reflex])
    return np.vstack(found) if found else np.empty((0, 2))
