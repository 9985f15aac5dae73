"""Where in a place centres may be that keep off the walls. Lengths in m."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stplan.maps.reader import Floor, MapError
from stplan.scene.model import Scene
from stplan.scene.places import Place
from stplan.schema.mapping import Fault

if TYPE_CHECKING:
    import shapely

# Spots lie so many times as far from walls as they have to: nobody is wedged in.
OFF_WALLS = 1.02


def floor_of(scene: Scene, faults: list[Fault]) -> Floor | None:
    """The floor of the map, None for the open plane, or with a new fault."""
    if scene.map is None:
        return None
    from stplan.maps.floor import read_floor

    try:
        return read_floor(scene.map)
    except MapError as fault:
        faults.append((fault.path, fault.text))
        return None


def region_of(place: Place, floor: Floor | None, room: float) -> shapely.Geometry:
    """The points of `place` on a `floor` (None is the open plane) that keep `room` (m) from its walls."""
    import shapely

    from stplan.maps.floor import polylines

    shape = place.shape()
    if floor is None:
        return shape
    with np.errstate(all="ignore"):
        area = shapely.buffer(floor.area, -room) if room > 0 else floor.area
        region = shapely.intersection(shape, area)
        if room > 0 and len(floor.slits):
            slits = shapely.union_all(shapely.buffer(polylines(floor.slits), room))
            region = shapely.difference(region, slits)
    return region
