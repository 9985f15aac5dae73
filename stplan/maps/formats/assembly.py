"""A drawing in metres -> the floor: what is drawn as floor, or enclosed by walls, less what blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely

from stplan.amounts import amount
from stplan.arrays import FloatArray
from stplan.maps.floor import polylines
from stplan.maps.formats.drawing import Drawing, FileOptions, FormatError
from stplan.maps.formats.gaps import bridges
from stplan.maps.formats.inner import inner_polygons
from stplan.maps.reader import Floor, Note

KEY = "map.file"
# Walls enclose a floor where it is at least this share of the rectangle around them.
ENCLOSED = 0.5
# So many parts are listed by their areas.
MOST_PARTS = 5
# What is done to shapes that are not simple.
MENDING = "mended: what is in doubt is not free"


def assembled(drawing: Drawing, options: FileOptions) -> Floor:
    """The floor of a drawing in metres.

    Raises:
        FormatError: there is none.
    """
    notes = list(drawing.notes)
    walls = [line for line in map(_distinct, drawing.walls) if len(line) > 1]
    if options.weld:
        joints = bridges(walls, options.weld)
        walls += joints
        if joints:
            notes.append(
                f"{len(joints)} gaps of at most {options.weld:g} m between walls were closed"
            )
    area = _base(drawing, walls, notes)
    blocked = list(drawing.blocked)
    if options.thickness:
        lines = polylines(walls)
        blocked += list(
            shapely.buffer(lines, options.thickness / 2, cap_style="square", join_style="mitre")
        )
        walls = []
    if blocked:
        area = shapely.difference(area, shapely.union_all(np.array(blocked, dtype=object)))
    parts = shapely.get_parts(area)
    parts = parts[(shapely.get_type_id(parts) == shapely.GeometryType.POLYGON)]
    parts = parts[shapely.area(parts) > 0]
    if not len(parts):
        raise FormatError("leaves no floor: what is drawn blocks all of it")
    tolerance = drawing.tolerance if options.simplify is None else options.simplify
    parts = inner_polygons(parts, tolerance)
    if len(parts) > 1:
        notes.append(_parts_note(parts))
    area = parts[0] if len(parts) == 1 else shapely.MultiPolygon(list(parts))
    if not area.is_valid:
        area = shapely.union_all(parts)
    said = [
        *(Note(KEY, text, MENDING) for text in drawing.mended),
        *(Note(KEY, text) for text in notes),
    ]
    return Floor(area, None, tuple(walls), tuple(said))


def _base(drawing: Drawing, walls: Sequence[FloatArray], notes: list[str]) -> Any:
    """The floor before anything is cut out of it."""
    if drawing.floors:
        return shapely.union_all(np.array(drawing.floors, dtype=object))
    if not (drawing.has_map or (drawing.margin is not None and drawing.shapes)):
        raise FormatError("draws neither floors nor walls; it is no map")
    box = shapely.total_bounds(np.array(drawing.shapes, dtype=object))
    if drawing.margin is not None:
        low, high = box[:2] - drawing.margin, box[2:] + drawing.margin
        return shapely.box(*low, *high)
    rectangle = shapely.box(*box)
    if rectangle.area == 0:
        raise FormatError("draws no floor, and its walls enclose none")
    lines = polylines(walls)
    outlines = shapely.boundary(np.array(drawing.blocked, dtype=object))
    rooms = shapely.polygonize([shapely.union_all(np.append(lines, outlines))])
    enclosed = shapely.union_all(shapely.get_parts(rooms))
    if enclosed.area >= ENCLOSED * rectangle.area:
        return enclosed
    notes.append(
        "draws no floor and its walls do not close: the rectangle around them is taken for the floor "
        "(name layers with map.floor, or close gaps with map.weld)"
    )
    return rectangle


def _distinct(line: FloatArray) -> FloatArray:
    """A polyline without points that repeat the one before."""
    same = (line[1:] == line[:-1]).all(axis=1)
    return line[np.append(True, ~same)]


def _parts_note(parts: FloatArray) -> str:
    areas = np.sort(shapely.area(parts))[::-1]
    listed = ", ".join(f"{amount(float(area))} m2" for area in areas[:MOST_PARTS])
    more = f" and {len(areas) - MOST_PARTS} smaller ones" if len(areas) > MOST_PARTS else ""
    return f"has {len(areas)} floors that do not connect: {listed}{more}"
