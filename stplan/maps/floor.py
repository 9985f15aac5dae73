"""A map as written -> the area that is left to move in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.obstacles import CircleObstacle, PolygonObstacle
from stplan.maps.reader import Floor, MapError
from stplan.maps.spec import MapSpec


def read_floor(spec: MapSpec) -> Floor:
    """The area of the map's base less the obstacles, m.

    Raises:
        MapError: a file of the map cannot be used, or nothing is left.
    """
    base = spec.base.floor()
    area = base.area
    if spec.obstacles:
        area = shapely.difference(area, _covered(spec.obstacles))
    parts = [p for p in shapely.get_parts(area) if isinstance(p, shapely.Polygon) and p.area > 0]
    if not parts:
        raise MapError("map", "has no area left to move in")
    return replace(base, area=parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts))


def _covered(obstacles: Sequence[PolygonObstacle | CircleObstacle]) -> shapely.Geometry:
    """The union of all obstacles: one cut is a hundred times faster than one for each."""
    shapes = polygons([obstacle.outline() for obstacle in obstacles])
    bad = np.flatnonzero(~shapely.is_valid(shapes) | (shapely.area(shapes) == 0))
    if len(bad):
        text = "has no area or cuts itself; a simple ring is expected"
        raise MapError(f"map.obstacles[{bad[0]}]", text)
    return shapely.disjoint_subset_union_all(shapes)


def polygons(rings: Sequence[FloatArray]) -> FloatArray:
    """(R,) polygons of rings of corners (n, 2), n >= 3."""
    owners = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    return np.asarray(shapely.polygons(shapely.linearrings(np.vstack(rings), indices=owners)))
