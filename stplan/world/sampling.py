"""Points of the plane that graphs are made of: lattices, rings off the walls, and their triangulation."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import Delaunay, QhullError, cKDTree

from stplan.arrays import FloatArray, IntArray
from stplan.world.erosion import eroded

# Rings lie this much further off than the radius asked for, and are simplified by less, so that
# every straight piece of a ring stays free.
RING_OFFSET = 1.02
RING_TOLERANCE = 0.012


def inside(region: shapely.Geometry, points: FloatArray) -> FloatArray:
    """The `points` (n, 2) inside `region`."""
    shapely.prepare(region)
    kept: FloatArray = points[shapely.contains_xy(region, points[:, 0], points[:, 1])]
    return kept


def box_around(places: FloatArray, room: float) -> shapely.Polygon:
    """A box around `places` (n, 2) with `room` (m) and a tenth of their extent on every side."""
    low, high = places.min(axis=0), places.max(axis=0)
    room += 0.1 * float((high - low).max())
    return shapely.box(low[0] - room, low[1] - room, high[0] + room, high[1] + room)


def hexagonal_points(region: shapely.Geometry, spacing: float) -> FloatArray:
    """A hexagonal lattice (n, 2) of `spacing` (m) inside `region`."""
    if region.is_empty:
        return np.empty((0, 2))
    left, bottom, right, top = region.bounds
    rise = spacing * np.sqrt(0.75)
    rows = np.arange(int((top - bottom) / rise) + 2)
    columns = np.arange(int((right - left) / spacing) + 2)
    x = left + (columns[None, :] + 0.5 * (rows[:, None] % 2)) * spacing
    y = np.broadcast_to(bottom + rows[:, None] * rise, x.shape)
    return inside(region, np.column_stack([x.ravel(), y.ravel()]))


def rings_of(area: shapely.Geometry) -> list[FloatArray]:
    """Closed coordinate rings (n, 2) of all polygons of `area`."""
    rings = []
    for polygon in shapely.get_parts(area):
        if isinstance(polygon, shapely.Polygon) and not polygon.is_empty:
            for ring in (polygon.exterior, *polygon.interiors):
                rings.append(np.asarray(ring.coords, dtype=np.float64)[:, :2])
    return rings


def along(ring: FloatArray, step: float) -> FloatArray:
    """Corners of a closed ring (n, 2) and points between them at most `step` (m) apart."""
    steps = np.diff(ring, axis=0)
    counts = np.maximum(np.ceil(np.hypot(steps[:, 0], steps[:, 1]) / step), 1.0).astype(np.int64)
    order = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    piece = np.repeat(np.arange(len(steps)), counts)
    points: FloatArray = ring[piece] + steps[piece] * (order / counts[piece])[:, None]
    return points


def rings_off_the_walls(region: shapely.Geometry, radius: float) -> list[FloatArray]:
    """Rings (n, 2) that follow the boundary of `region` just over `radius` (m) off it.

    Corners are mitred: round ones would be cut by the edges between their points.
    """
    inner = eroded(region, radius * RING_OFFSET, join_style="mitre", mitre_limit=1.6)
    return rings_of(shapely.simplify(inner, RING_TOLERANCE * radius))


def points_of_rings(rings: list[FloatArray], step: float) -> FloatArray:
    """Corners of all rings and points at most `step` (m) apart, (n, 2)."""
    return np.vstack([np.empty((0, 2)), *(along(ring, step) for ring in rings)])


def thinned(points: FloatArray, apart: FloatArray) -> FloatArray:
    """`points` in order, each left out that has a kept one before it nearer than its `apart` (m)."""
    if len(points) == 0:
        return points
    near = cKDTree(points).query_ball_point(points, apart, return_sorted=True)
    kept = np.ones(len(points), dtype=bool)
    for index in np.flatnonzero(apart > 0).tolist():
        for other in near[index]:
            if other >= index:
                break
            if kept[other]:
                kept[index] = False
                break
    return points[kept]


def delaunay_edges(points: FloatArray) -> IntArray:
    """(E, 2) edges of the Delaunay triangulation of `points` (n, 2), rising within and between rows.

    Points on a line are linked to their neighbours along it.
    """
    try:
        triangles = Delaunay(_near_origin(points)).simplices
    except (QhullError, ValueError):
        order = np.lexsort((points[:, 1], points[:, 0]))
        return unique_edges(np.column_stack([order[:-1], order[1:]]))
    return unique_edges(triangles.astype(np.int64)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))


def _near_origin(points: FloatArray) -> FloatArray:
    """`points` moved by whole extents: far from the origin Qhull takes neighbours for one point."""
    low, high = points.min(axis=0), points.max(axis=0)
    extent = max(float((high - low).max()), 1e-9)
    return points - extent * np.trunc((low + high) / (2.0 * extent))


def unique_edges(edges: IntArray) -> IntArray:
    """Every pair of `edges` (n, 2) once, rising within and between rows."""
    return np.unique(np.sort(edges, axis=1), axis=0).reshape(-1, 2)


def ties(places: IntArray, vertices: FloatArray, count: int) -> IntArray:
    """(n, 2) pairs of each of `places` (indices of vertices) and its up to `count` nearest ones."""
    if not len(places) or len(vertices) < 2:
        return np.empty((0, 2), dtype=np.int64)
    near = cKDTree(vertices).query(vertices[places], k=min(count + 1, len(vertices)))[1]
    pairs = np.column_stack([np.repeat(places, near.shape[1]), near.ravel()]).astype(np.int64)
    return pairs[pairs[:, 0] != pairs[:, 1]]
