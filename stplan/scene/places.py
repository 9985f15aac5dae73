"""Parts of the plane in which agents start and end. Lengths in m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import Point

if TYPE_CHECKING:
    import shapely


@dataclass(frozen=True)
class Place:
    """A part of the plane.

    Attributes:
        name: what the scene calls it, empty where it stands with an agent.
        points: corners of an area (a disc is a polygon inscribed in it), or a polyline.
        area: whether it is an area; lines have none.
    """

    name: str
    points: tuple[Point, ...]
    area: bool

    def __str__(self) -> str:
        """What to call it."""
        return f"place {self.name}" if self.name else "the place"

    def shape(self) -> shapely.Geometry:
        """A polygon, or a line."""
        import shapely

        points = np.array(self.points)
        return shapely.polygons(points) if self.area else shapely.linestrings(points)


@dataclass(frozen=True)
class Assignment:
    """Agents (indices) of which everybody ends on a point of its own; which one, planning decides."""

    members: tuple[int, ...]
    points: tuple[Point, ...]
