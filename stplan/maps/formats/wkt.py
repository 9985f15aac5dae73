"""Well-known text (``.wkt``), of JuPedSim and geographic systems: polygons are floor, lines walls."""

from __future__ import annotations

import re

import numpy as np
import shapely

from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    MOST_CORNERS,
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    repaired,
)
from stplan.maps.formats.json_tree import LARGEST_TEXT

# Brackets inside one another: a collection of multipolygons of polygons of rings needs 5.
DEEPEST = 12


def read_wkt(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """Every geometry of the text, one or more lines each."""
    del options, beside
    text = file.content.decode("utf-8-sig", "replace")
    return drawing_of(wkt_shapes(text))


def wkt_shapes(text: str) -> list[shapely.Geometry]:
    """The geometries of a text, collections taken apart.

    Raises:
        FormatError: it is no well-known text, or more than is read.
    """
    if len(text) > LARGEST_TEXT or text.count(",") > MOST_CORNERS:
        raise FormatError(f"has more than {MOST_CORNERS} corners")
    shapes: list[shapely.Geometry] = []
    for start, piece in _pieces(text):
        line = text.count("\n", 0, start) + 1
        try:
            with np.errstate(all="ignore"):
                shape = shapely.from_wkt(re.sub(r"^\s*SRID=\d+;", "", piece))
        except (shapely.errors.GEOSException, NotImplementedError) as error:
            reason = str(error).splitlines()[0][:200]
            raise FormatError(f"is no valid well-known text: {reason}", line) from error
        if not np.isfinite(shapely.get_coordinates(shape)).all():
            raise FormatError("has a coordinate that is no finite number", line)
        shapes += _parts(shape)
    if not shapes:
        raise FormatError("holds no geometry", 1)
    return shapes


def _pieces(text: str) -> list[tuple[int, str]]:
    """(where it begins, text) of every geometry; brackets are counted before anything is parsed."""
    found = []
    depth = begin = 0
    for match in re.finditer(r"[()]|EMPTY", text):
        depth += {"(": 1, ")": -1}.get(match[0], 0)
        if depth > DEEPEST:
            line = text.count("\n", 0, match.start()) + 1
            raise FormatError(f"is nested more than {DEEPEST} brackets deep", line)
        if depth <= 0:
            found.append((begin, text[begin : match.end()].lstrip(" \t\r\n;")))
            begin, depth = match.end(), 0
    rest = text[begin:].strip(" \t\r\n;\x00")
    return [*found, (begin, rest)] if rest else found


def _parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    parts = [shape]
    while any(hasattr(part, "geoms") for part in parts):
        parts = [inner for part in parts for inner in getattr(part, "geoms", (part,))]
    return [shapely.force_2d(part) for part in parts if not part.is_empty]


def drawing_of(shapes: list[shapely.Geometry]) -> Drawing:
    """Polygons as floor, lines as walls; points are left out."""
    areas = [one for one in shapes if isinstance(one, shapely.Polygon)]
    lines = [one for one in shapes if isinstance(one, shapely.LineString | shapely.LinearRing)]
    floors, mended = repaired(areas, "polygons")
    left = len(shapes) - len(areas) - len(lines)
    notes = (f"{left} points were left out",) if left else ()
    walls = tuple(np.asarray(shapely.get_coordinates(line)) for line in lines)
    return Drawing(floors=floors, walls=walls, notes=notes, mended=mended)


WKT = ForeignFormat("well-known text", (".wkt",), read_wkt)
