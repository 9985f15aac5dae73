"""Where in a place a disc can be: its parts that are far enough from the walls. Lengths in m."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.scene.places import Place
from stplan.world.erosion import eroded
from stplan.world.free_space import FreeSpace
from stplan.world.sampling import hexagonal_points


class StandingRoom:
    """Where centres of discs may be in places of one map; worked out once for every radius.

    Args:
        free_space: the map, None for the open plane.
    """

    def __init__(self, free_space: FreeSpace | None) -> None:
        self._free_space = free_space
        self._eroded: dict[float, shapely.Geometry] = {}

    def area(self, radius: float) -> shapely.Geometry | None:
        """Where a centre may be that keeps `radius` (m) from the walls, None for anywhere."""
        if self._free_space is None:
            return None
        if radius not in self._eroded:
            self._eroded[radius] = eroded(self._free_space.polygon, radius, quad_segs=16)
        return self._eroded[radius]

    def within(self, place: Place, radius: float) -> shapely.Geometry:
        """The part of a place where a centre may be."""
        area = self.area(radius)
        return place.shape() if area is None else shapely.intersection(place.shape(), area)

    def reachable(self, place: Place, start: tuple[float, float], radius: float) -> bool:
        """Whether a disc can come from `start` to a point of `place`."""
        area = self.area(radius)
        if area is None:
            return True
        parts = shapely.get_parts(area)
        at, shape = shapely.points(start), place.shape()
        near = parts[shapely.distance(parts, at) <= 1e-9]
        return bool(shapely.intersects(near, shape).any())


def spots(room: shapely.Geometry, spacing: float, inset: float) -> FloatArray:
    """(n, 2) points of `room` (an area, or lines), no two nearer than `spacing` (m).

    In an area they form a lattice, as far inside as `inset` (m) allows; along lines they are spread evenly
    and keep `inset` from the ends.
    """
    found = [np.empty((0, 2))]
    for part in shapely.get_parts(room):
        if shapely.area(part) > 0:
            inner = eroded(part, inset)
            lattice = hexagonal_points(part if inner.is_empty else inner, spacing)
            middle = shapely.get_coordinates(shapely.point_on_surface(part))
            found.append(lattice if len(lattice) else middle)
        elif shapely.length(part) > 0:
            length = float(shapely.length(part))
            gap = min(inset, 0.25 * length)
            count = int((length - 2.0 * gap) / spacing + 1e-9) + 1
            at = np.array([0.5 * length]) if count == 1 else np.linspace(gap, length - gap, count)
            found.append(shapely.get_coordinates(shapely.line_interpolate_point(part, at)))
    return np.vstack(found)
