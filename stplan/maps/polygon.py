"""Maps written in the scene itself: an outer ring with holes, or a rectangle. Lengths in m."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from stplan.arrays import Point
from stplan.maps.reader import Floor, MapBase, MapReader
from stplan.maps.rings import RepairKeys, read_ring, rectangle_ring
from stplan.schema.mapping import GIVEN, Fault, FileModel, key
from stplan.schema.quantities import Rectangle, Ring


class PolygonKeys(RepairKeys):
    """A polygon as the map."""

    polygon: Annotated[Ring | None, GIVEN] = key("base: an outer ring [[x, y], ...] in m")
    holes: Annotated[list[Ring] | None, GIVEN] = key("rings in m, cut out of `polygon`")


class RectangleKeys(FileModel):
    """A rectangle as the map."""

    rectangle: Annotated[Rectangle | None, GIVEN] = key("base: [xmin, ymin, xmax, ymax] in m")


_APART = (
    "holes inside the polygon and apart are expected (`obstacles` may reach its edge and each other), "
    "or map.repair: true"
)


@dataclass(frozen=True)
class PolygonBase(MapBase):
    """An outer ring with holes (a rectangle is four points)."""

    outer: tuple[Point, ...]
    holes: tuple[tuple[Point, ...], ...] = ()

    def floor(self) -> Floor:
        """The ring's inside less its holes'. What is not simple is mended and noted."""
        import shapely

        drawn = shapely.Polygon(np.array(self.outer), [np.array(hole) for hole in self.holes])
        if shapely.is_valid(drawn) and drawn.area > 0:
            return Floor(drawn)
        from stplan.maps.repair import without_holes

        return without_holes(self.outer, self.holes)

    def meaning(self) -> dict[str, Any]:
        """What the scene says, as it is hashed."""
        return {"outer": self.outer, "holes": self.holes}


def _polygon(entry: PolygonKeys, folder: Path, faults: list[Fault]) -> PolygonBase:
    del folder
    before, repair = len(faults), entry.repair is not False
    base = PolygonBase(
        read_ring(entry.polygon or [], "map.polygon", faults, repair=repair),
        tuple(
            read_ring(hole, f"map.holes[{k}]", faults, repair=repair)
            for k, hole in enumerate(entry.holes or [])
        ),
    )
    if len(faults) == before and base.holes and not repair:
        faults.extend((note.path, f"{note.text}; {_APART}") for note in base.floor().notes)
    return base


def _rectangle(entry: RectangleKeys, folder: Path, faults: list[Fault]) -> PolygonBase:
    del folder
    return PolygonBase(rectangle_ring(entry.rectangle or [0, 0, 1, 1], "map.rectangle", faults))


POLYGON = MapReader(
    "polygon", PolygonKeys, _polygon, "a polygon",
    {"holes": "with other bases, obstacles do the same"},
)  # fmt: skip
RECTANGLE = MapReader("rectangle", RectangleKeys, _rectangle, "a rectangle")
