"""What is cut out of a map: rectangles, polygons, discs, lines. Lengths in m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stplan.arrays import FloatArray, Point
from stplan.maps.rings import polyline, read_ring, rectangle_ring
from stplan.schema.mapping import GIVEN, Fault, FileModel, key
from stplan.schema.quantities import Point as PointKey
from stplan.schema.quantities import Polyline, Positive, Rectangle, Ring

# Sides of the polygon that stands for a disc; it contains the disc, so nobody gets closer than asked.
CIRCLE_SIDES = 64


class CircleFile(FileModel):
    """A disc."""

    center: PointKey = Field(description="[x, y] in m")
    radius: Positive = Field(description="radius, m")


class ObstacleFile(FileModel):
    """Exactly one shape, cut out of the map."""

    rectangle: Annotated[Rectangle | None, GIVEN] = key("[xmin, ymin, xmax, ymax] in m")
    polygon: Annotated[Ring | None, GIVEN] = key("[[x, y], ...] in m, a ring that is not closed")
    circle: Annotated[CircleFile | None, GIVEN] = key("a disc")
    line: Annotated[Polyline | None, GIVEN] = key("[[x, y], ...] in m, a wall along this polyline")
    thickness: Annotated[Positive | None, GIVEN] = key(
        "of the wall along `line`, m, half to either side; default: none"
    )


@dataclass(frozen=True)
class PolygonObstacle:
    """An area cut out of the base (a rectangle is four points)."""

    ring: tuple[Point, ...]

    def outline(self) -> FloatArray:
        """(n, 2) corners."""
        return np.array(self.ring)

    def meaning(self) -> dict[str, Any]:
        """What the scene says, as it is hashed."""
        return {"ring": self.ring}


@dataclass(frozen=True)
class CircleObstacle:
    """A disc cut out of the base."""

    center: Point
    radius: float

    def outline(self) -> FloatArray:
        """(n, 2) corners of a polygon around the disc."""
        angle = 2 * np.pi * np.arange(CIRCLE_SIDES) / CIRCLE_SIDES
        reach = self.radius / np.cos(np.pi / CIRCLE_SIDES)
        return np.array(self.center) + reach * np.column_stack([np.cos(angle), np.sin(angle)])


@dataclass(frozen=True)
class LineObstacle:
    """A wall along a polyline, closed where its ends coincide; None is no thickness at all (m)."""

    line: tuple[Point, ...]
    thickness: float | None = None

    def meaning(self) -> dict[str, Any]:
        """What the scene says, as it is hashed."""
        return {"line": self.line, "thickness": self.thickness}


Obstacle = PolygonObstacle | CircleObstacle | LineObstacle


def compile_obstacle(
    entry: ObstacleFile, path: str, faults: list[Fault], *, repair: bool = False
) -> Obstacle:
    """The obstacle; with new `faults` it must not be used. Rings are mended later where `repair`."""
    exactly_one(entry, ("rectangle", "polygon", "circle", "line"), path, faults)
    if entry.thickness is not None and entry.line is None:
        faults.append((f"{path}.thickness", "belongs to a line, and there is none"))
    if entry.line is not None:
        return LineObstacle(polyline(entry.line, f"{path}.line", faults), entry.thickness)
    if entry.circle is not None:
        x, y = entry.circle.center
        return CircleObstacle((x, y), entry.circle.radius)
    if entry.polygon is not None:
        return PolygonObstacle(read_ring(entry.polygon, f"{path}.polygon", faults, repair=repair))
    corners = entry.rectangle or [0, 0, 1, 1]
    return PolygonObstacle(rectangle_ring(corners, f"{path}.rectangle", faults))


def exactly_one(
    entry: FileModel, keys: tuple[str, ...], path: str, faults: list[Fault]
) -> str | None:
    """The one of `keys` that is given; a fault where there are none or several."""
    given = [name for name in keys if getattr(entry, name) is not None]
    if len(given) != 1:
        *most, last = keys
        found = " and ".join(given) or "none"
        faults.append((path, f"has {found} of {', '.join(most)} and {last}; one is expected"))
    return given[0] if given else None
