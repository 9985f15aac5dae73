"""Drawings of CAD (``.dxf``): lines, polylines, arcs, circles, splines, solids and hatches, by layer.

Lines are walls without thickness, polylines with a width as wide as drawn. Curves become chords within 5 mm,
and what surely holds the curve is blocked. Blocks are inserted wherever they are used.
"""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.files import FileContent
from stplan.maps.formats.curves import thick
from stplan.maps.formats.drawing import (
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    check_crossings,
    repaired,
)
from stplan.optional import require

LARGEST_FILE = 32 * 1024 * 1024
MOST_LINES = 1_500_000
# Entities in all, those of blocks counted as often as they are inserted.
MOST_ENTITIES = 100_000
DEEPEST_BLOCK = 16
# Extent of a curve, in tolerances of its chords: some 10,000 of them.
_LARGEST_CURVE = 1e8
# All corners, those of curves and hatches included.
MOST_CORNERS = 500_000
# Boundaries of a hatch times corners of all of them.
_MOST_HATCHED = 5_000_000
# How far chords may be from a curve, m.
_SAG = 0.005
# Codes of $INSUNITS -> m.
_UNITS = {
    1: 0.0254,
    2: 0.3048,
    4: 0.001,
    5: 0.01,
    6: 1.0,
    7: 1000.0,
    10: 0.9144,
    14: 0.1,
    21: 0.3048006096,
}
_LINES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "MLINE")
_CURVED = ("ARC", "CIRCLE", "ELLIPSE", "SPLINE")
_FILLED = ("SOLID", "TRACE", "3DFACE")
# Of no area, and no wall in any drawing.
_SILENT = {
    "TEXT",
    "MTEXT",
    "DIMENSION",
    "ATTDEF",
    "ATTRIB",
    "LEADER",
    "MULTILEADER",
    "POINT",
    "VIEWPORT",
    "XLINE",
    "RAY",
}


def read_dxf(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """The model space. Closed shapes on the layers of `floor` are floor, everything on `layers` blocks."""
    del beside
    document = _document(file)
    unit = _UNITS.get(int(document.header.get("$INSUNITS", 0)))
    scale = options.scale if options.scale is not None else unit or 1.0
    reader = _Reader(options, _SAG / scale)
    try:
        for entity in _entities(document.modelspace(), "0"):
            reader.add(*entity)
    except (FormatError, MemoryError):
        raise
    except Exception as error:  # entities of a damaged file may raise anything at all
        raise FormatError(f"has an entity that cannot be read: {type(error).__name__}") from error
    notes = list(reader.notes)
    if unit is None and options.scale is None:
        notes.append("has no unit: metres are taken (map.scale says another, such as 0.001)")
    floors, mended = repaired(reader.floors, "floors")
    blocked, more = repaired(reader.blocked, "shapes", blocked=True)
    return Drawing(
        floors=floors, blocked=blocked, walls=tuple(reader.walls), unit=unit or 1.0,
        names=tuple(reader.layers), notes=tuple(notes), mended=mended + more,
    )  # fmt: skip


def _document(file: FileContent) -> Any:
    if len(file.content) > LARGEST_FILE:
        raise FormatError(f"is larger than {LARGEST_FILE // 2**20} MiB")
    if file.content.count(b"\n") > MOST_LINES:
        raise FormatError(f"has more than {MOST_LINES} lines")
    ezdxf = require("ezdxf", "a DXF drawing", "maps")
    recover = require("ezdxf.recover", "a DXF drawing", "maps")
    logger = logging.getLogger("ezdxf")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        document, _ = recover.read(io.BytesIO(file.content))
        return document
    except (ezdxf.DXFError, MemoryError) as error:
        if isinstance(error, MemoryError):
            raise
        raise FormatError(f"is no DXF drawing that can be read: {str(error)[:200]}") from error
    except Exception as error:  # a hostile file may raise anything at all inside the reader
        raise FormatError("cannot be read: it is damaged, cut short or no DXF drawing") from error
    finally:
        logger.setLevel(level)


def _entities(space: Any, layer: str) -> Iterator[tuple[Any, str]]:
    """(entity, its layer) of a space, blocks taken apart.

    What is on layer 0 of a block is on the layer of its insertion.
    """
    count = 0
    stack: list[tuple[Iterator[Any], str, int]] = [(iter(space), layer, 0)]
    while stack:
        entities, outer, depth = stack[-1]
        entity = next(entities, None)
        if entity is None:
            stack.pop()
            continue
        count += 1
        if count > MOST_ENTITIES:
            raise FormatError(
                f"has more than {MOST_ENTITIES} entities, those of blocks counted as often as inserted"
            )
        own = entity.dxf.get("layer", "0")
        own = outer if own == "0" and depth else own
        if entity.dxf.get("invisible", 0):
            continue
        if entity.dxftype() == "INSERT":
            if depth >= DEEPEST_BLOCK:
                raise FormatError(f"has blocks inside blocks, more than {DEEPEST_BLOCK} deep")
            for one in entity.multi_insert() if entity.mcount > 1 else (entity,):
                count += 1
                if count > MOST_ENTITIES:
                    break
                stack.append((one.virtual_entities(), own, depth + 1))
        else:
            yield entity, own


class _Reader:
    """Sorts entities into floors, blocked areas and walls, in units of the file."""

    def __init__(self, options: FileOptions, sag: float) -> None:
        self.floor = {name.lower() for name in options.floor}
        self.chosen = {name.lower() for name in options.layers}
        self.sag = sag
        self.floors: list[Any] = []
        self.blocked: list[Any] = []
        self.walls: list[FloatArray] = []
        self.layers: dict[str, int] = {}
        self.left: dict[str, int] = {}
        self.corners = 0

    @property
    def notes(self) -> list[str]:
        """What was read, and what was not."""
        listed = ", ".join(f"{name} ({count})" for name, count in [*self.layers.items()][:20])
        found = (
            [f"has the layers {listed}"]
            if not (self.floor or self.chosen) and len(self.layers) > 1
            else []
        )
        if self.left:
            listed = ", ".join(f"{count} {kind}" for kind, count in sorted(self.left.items()))
            found.append(f"{listed} were left out")
        return found

    def add(self, entity: Any, layer: str) -> None:
        """Sort an entity of a layer."""
        kind = entity.dxftype()
        if kind in _SILENT:
            return
        self.layers[layer] = self.layers.get(layer, 0) + 1
        name = layer.lower()
        is_floor = name in self.floor
        if not is_floor and self.chosen and name not in self.chosen:
            return
        if kind in _FILLED:
            self._fill(entity, is_floor=is_floor)
        elif kind == "HATCH":
            self._hatch(entity, is_floor=is_floor)
        elif kind in _LINES:
            self._line(entity, kind, is_floor=is_floor)
        else:
            self._leave(kind)

    def _leave(self, what: str) -> None:
        self.left[what] = self.left.get(what, 0) + 1

    def _fill(self, entity: Any, *, is_floor: bool) -> None:
        corners = np.array([[p.x, p.y] for p in entity.wcs_vertices()])
        (self.floors if is_floor else self.blocked).append(shapely.Polygon(corners))

    def _line(self, entity: Any, kind: str, *, is_floor: bool) -> None:
        if kind == "MLINE":
            for part in entity.virtual_entities():
                self._line(part, part.dxftype(), is_floor=is_floor)
            return
        if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
            # A surface: what is below or above its faces.
            faces = [part for part in entity.virtual_entities() if part.dxftype() in _FILLED]
            for face in faces:
                self._fill(face, is_floor=is_floor)
            if not faces:
                self._leave("POLYLINE of a surface")
            return
        path = require("ezdxf.path", "a DXF drawing", "maps").make_path(entity)
        wide = _width(entity, kind)
        for part in path.sub_paths() if path.has_sub_paths else (path,):
            if len(part) == 0:
                continue
            points = self._flattened(part)
            if is_floor:
                if part.is_closed and len(points) > 3:
                    self.floors.append(self._shrunk(shapely.Polygon(points), part.has_curves))
            elif wide > 0:
                self.blocked.append(_stroke(points, wide / 2 + self.sag * part.has_curves))
            elif part.has_curves:
                self.blocked.append(thick(points, self.sag))
            else:
                self.walls.append(points)

    def _hatch(self, entity: Any, *, is_floor: bool) -> None:
        paths = list(require("ezdxf.path", "a DXF drawing", "maps").from_hatch(entity))
        area = shapely.Polygon()
        curved, corners = False, 0
        for path in paths:
            points = self._flattened(path)
            curved |= path.has_curves
            if len(points) > 2:
                # Boundaries inside one another are holes.
                shape = shapely.make_valid(shapely.Polygon(points))
                area = shapely.symmetric_difference(area, shape)
                corners += len(points)
                if corners * len(paths) > _MOST_HATCHED:
                    raise FormatError("has a hatch of too many boundaries")
        if is_floor:
            self.floors.append(self._shrunk(area, curved))
        else:
            self.blocked.append(shapely.buffer(area, self.sag) if curved else area)

    def _flattened(self, path: Any) -> FloatArray:
        """(n, 2) chords of a path."""
        if path.has_curves:
            controls = np.array([[p.x, p.y] for p in path.control_vertices()])
            if not np.ptp(controls, axis=0).max() <= _LARGEST_CURVE * self.sag:
                raise FormatError("has a curve that is absurdly large")
        points = np.array([[p.x, p.y] for p in path.flattening(self.sag)])
        self.corners += len(points)
        if self.corners > MOST_CORNERS:
            raise FormatError(f"has more than {MOST_CORNERS} corners, those of curves included")
        return points

    def _shrunk(self, area: Any, curved: bool) -> Any:
        """A floor that is inside its curved outline whatever the chords."""
        return shapely.buffer(area, -self.sag) if curved else area


def _width(entity: Any, kind: str) -> float:
    """How wide a polyline is drawn, where it is widest."""
    if kind == "LWPOLYLINE":
        if entity.dxf.get("const_width", 0.0):
            return float(entity.dxf.const_width)
        return max((max(start, end) for start, end in entity.get_points("se")), default=0.0)
    if kind == "POLYLINE" and entity.is_2d_polyline:
        usual = [entity.dxf.get(key, 0.0) for key in ("default_start_width", "default_end_width")]
        own = [
            vertex.dxf.get(key, 0.0)
            for vertex in entity.vertices
            for key in ("start_width", "end_width")
        ]
        return float(max(usual + own))
    return 0.0


def _stroke(points: FloatArray, reach: float) -> Any:
    """The area of a line that is drawn wide; its ends are flat."""
    check_crossings([shapely.linestrings(points)])
    if len(points) > 3 and (points[0] == points[-1]).all():
        return shapely.buffer(shapely.linearrings(points), reach, join_style="mitre")
    return shapely.buffer(shapely.linestrings(points), reach, cap_style="flat", join_style="mitre")


DXF = ForeignFormat("DXF drawing", (".dxf",), read_dxf, frozenset({"layers", "floor"}))
