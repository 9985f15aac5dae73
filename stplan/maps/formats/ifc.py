"""Building models (``.ifc``): slabs, walls and columns of a storey, cut at knee height, in m."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    repaired,
)
from stplan.optional import require

LARGEST_FILE = 64 * 1024 * 1024
# Above the floor, m: below window sills, within doors.
CUT = 0.3
_BLOCKING = (
    "IfcWall",
    "IfcColumn",
    "IfcCurtainWall",
    "IfcRailing",
    "IfcFurnishingElement",
    "IfcStair",
)


def read_ifc(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """A storey: the slabs it stands on are floor, what stands on them blocks, openings of walls are doors."""
    del beside
    if len(file.content) > LARGEST_FILE:
        raise FormatError(f"is larger than {LARGEST_FILE // 2**20} MiB")
    if not file.content.lstrip().startswith(b"ISO-10303-21"):
        raise FormatError("is no IFC model: ISO-10303-21 is expected at its head", 1)
    ifcopenshell = require("ifcopenshell", "an IFC model", "bim")
    try:
        model = ifcopenshell.file.from_string(file.content.decode("latin-1"))
        storeys = sorted(
            model.by_type("IfcBuildingStorey"), key=lambda one: float(one.Elevation or 0.0)
        )
    except Exception as error:  # a hostile file may raise anything at all inside the reader
        raise FormatError("cannot be read: it is damaged, cut short or no IFC model") from error
    names = [str(one.Name or one.GlobalId) for one in storeys]
    chosen = options.level or (names[0] if names else "")
    if chosen not in names:
        raise FormatError(f"has no storey {chosen!r}; it has: {', '.join(names[:20]) or 'none'}")
    storey = storeys[names.index(chosen)]
    try:
        floors, blocked = _cut(model, storey)
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # shapes of a damaged file may raise anything at all
        raise FormatError("has shapes that cannot be made") from error
    whole, mended = repaired(floors, "slabs")
    solid, more = repaired(blocked, "walls", blocked=True)
    if len(names) > 1 and options.level is None:
        more += (
            f"is read on the storey {chosen}; map.level chooses among the others: {', '.join(names[1:20])}",
        )
    return Drawing(floors=whole, blocked=solid, names=tuple(names), mended=mended + more)


def _cut(model: Any, storey: Any) -> tuple[list[Any], list[Any]]:
    """Outlines of slabs from above, and of what stands on them in the plane of the cut."""
    geometry = require("ifcopenshell.geom", "an IFC model", "bim")
    element_of = require("ifcopenshell.util.element", "an IFC model", "bim")
    unit_of = require("ifcopenshell.util.unit", "an IFC model", "bim")
    settings = geometry.settings()
    settings.set("use-world-coords", True)
    elevation = float(storey.Elevation or 0.0) * float(unit_of.calculate_unit_scale(model))
    floors: list[Any] = []
    blocked: list[Any] = []
    for element in element_of.get_decomposition(storey):
        is_slab = element.is_a("IfcSlab")
        if not is_slab and not any(element.is_a(kind) for kind in _BLOCKING):
            continue
        if element.Representation is None:
            continue
        shape = geometry.create_shape(settings, element).geometry
        vertices = np.array(shape.verts, dtype=np.float64).reshape(-1, 3)
        triangles = np.array(shape.faces, dtype=np.int64).reshape(-1, 3)
        if is_slab and vertices[:, 2].max() <= elevation + CUT:
            floors.append(shapely.union_all(_seen_from_above(vertices[triangles])))
        elif not is_slab:
            blocked.append(_section(vertices[triangles], elevation + CUT))
    return floors, blocked


def _seen_from_above(corners: FloatArray) -> FloatArray:
    """Triangles (F, 3, 3) projected, those without area left out."""
    flat = shapely.polygons(corners[:, :, :2])
    return np.asarray(flat[shapely.area(flat) > 1e-9])


def _section(corners: FloatArray, height: float) -> Any:
    """The area in which closed triangles (F, 3, 3) are cut at a height."""
    above = corners[:, :, 2] > height
    cut = corners[above.any(axis=1) & ~above.all(axis=1)]
    segments = []
    for triangle in cut:
        ends = []
        for k in range(3):
            a, b = triangle[k], triangle[(k + 1) % 3]
            if (a[2] > height) != (b[2] > height):
                ends.append(a[:2] + (height - a[2]) / (b[2] - a[2]) * (b[:2] - a[:2]))
        segments.append(ends)
    if not segments:
        return shapely.Polygon()
    lines = shapely.set_precision(shapely.linestrings(np.array(segments)), 1e-6)
    rooms = shapely.polygonize([shapely.union_all(lines)])
    outline = shapely.union_all(shapely.get_parts(rooms))
    # Where the outline does not close, what is cut blocks as a whole.
    return outline if outline.area > 0 else shapely.buffer(shapely.union_all(lines), 0.01)


IFC = ForeignFormat("IFC model", (".ifc",), read_ifc, frozenset({"level"}))
