"""Shortest ways by brute force: a visibility graph over the corners of an area."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from stplan.arrays import FloatArray

# Segments may leave an area by this much, m: those along its sides do, by rounding.
ROUNDING = 1e-7


def visibility_length(area: shapely.Geometry, start: FloatArray, goal: FloatArray) -> float:
    """Length of the shortest way between two places of an area, inf where there is none; m."""
    corners = shapely.get_coordinates(area)
    points = np.vstack([start, goal, np.unique(corners, axis=0)])
    first, second = np.triu_indices(len(points), 1)
    lines = shapely.linestrings(np.stack([points[first], points[second]], axis=1))
    covering = shapely.buffer(area, ROUNDING, join_style="mitre")
    shapely.prepare(covering)
    # Most are settled by looking at their middles.
    middles = (points[first] + points[second]) / 2
    seen = shapely.intersects_xy(covering, *middles.T)
    seen[seen] = shapely.covers(covering, lines[seen])
    length = np.hypot(*(points[first] - points[second]).T)
    graph = csr_array((length[seen], (first[seen], second[seen])), shape=(len(points), len(points)))
    return float(dijkstra(graph, directed=False, indices=[0])[0, 1])


def shortest_bounds(
    floor: shapely.Geometry, radius: float, start: FloatArray, goal: FloatArray, pieces: int
) -> tuple[float, float]:
    """Bounds of the shortest way of a disc: arcs of a quarter circle as so many chords, or tangents."""
    chords = shapely.buffer(floor, -radius, quad_segs=pieces)
    outside = radius / np.cos(np.pi / (4 * pieces))
    tangents = shapely.buffer(floor, -outside, quad_segs=pieces)
    return visibility_length(chords, start, goal), visibility_length(tangents, start, goal)
