"""A map as written -> the area that is left to move in."""

from __future__ import annotations

from dataclasses import replace

import shapely

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
    for number, obstacle in enumerate(spec.obstacles):
        shape = obstacle_polygon(obstacle)
        if not shape.is_valid or shape.area == 0:
            raise MapError(
                f"map.obstacles[{number}]",
                "has no area or cuts itself; a simple ring is expected",
            )
        area = shapely.difference(area, shape)
    parts = [p for p in shapely.get_parts(area) if isinstance(p, shapely.Polygon) and p.area > 0]
    if not parts:
        raise MapError("map", "has no area left to move in")
    return replace(base, area=parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts))


def obstacle_polygon(obstacle: PolygonObstacle | CircleObstacle) -> shapely.Polygon:
    """An obstacle as a polygon; a disc is circumscribed."""
    return shapely.Polygon(obstacle.outline())
