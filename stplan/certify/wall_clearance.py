"""Distance of whole paths to the boundary of the free space, exactly, and whether they stay inside."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.world import FreeSpace


def wall_distance(free_space: FreeSpace, curve: FloatArray) -> tuple[float, FloatArray]:
    """Signed distance of a path to the boundary in m, and the (x, y) of the path where it is least.

    Negative where the path leaves the free space, by as much as its furthest knot lies outside (or
    minus zero's neighbour where only a segment does).
    """
    path = _path(curve)
    boundary = free_space.boundary
    line = shapely.shortest_line(path, boundary)
    place = np.array(line.coords[0])
    distance = float(shapely.distance(path, boundary))
    if shapely.covers(free_space.polygon, path):
        return distance, place
    outside = shapely.distance(shapely.points(curve[:, :2]), free_space.polygon)
    worst = int(outside.argmax())
    if outside[worst] > 0:
        return -float(outside[worst]), curve[worst, :2].copy()
    return -float(np.finfo(float).tiny), place


def _path(curve: FloatArray) -> shapely.Geometry:
    """The path in the plane: a line, or a point for an agent that never moves."""
    points = curve[:, :2]
    moves = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
    points = points[moves]
    return shapely.Point(points[0]) if len(points) == 1 else shapely.LineString(points)


def time_at(curve: FloatArray, place: FloatArray) -> float:
    """When a path passes nearest to `place` (x, y), s."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    squared = (step[:, :2] ** 2).sum(axis=1)
    along = ((place - start[:, :2]) * step[:, :2]).sum(axis=1) / np.where(squared > 0, squared, 1)
    along = np.clip(along, 0.0, 1.0)
    gap = np.hypot(*(start[:, :2] + along[:, None] * step[:, :2] - place).T)
    best = int(gap.argmin())
    return float(start[best, 2] + along[best] * step[best, 2])
