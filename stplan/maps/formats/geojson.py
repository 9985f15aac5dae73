"""GeoJSON: polygons are floor or obstacles by their kind, lines walls, points named spots.

Its standard (RFC 7946) says degrees; a `scale` says that the numbers are lengths. Degrees are projected
onto the plane that touches the earth in the middle of the file (azimuthal, equidistant from there).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray, Point
from stplan.maps.files import FileContent
from stplan.maps.formats.drawing import (
    MOST_SHAPES,
    Beside,
    Drawing,
    FileOptions,
    ForeignFormat,
    FormatError,
    repaired,
)
from stplan.maps.formats.json_tree import members, place, read_json_tree
from stplan.optional import require

# Properties that say of which kind a feature is, in this order.
_KINDS = ("layer", "kind", "role", "type", "class", "category", "name")
_BLOCKING = {"obstacle", "obstacles", "wall", "walls", "hole", "holes", "pillar", "keepout", "keep-out",
             "keep_out", "blocked", "no-go", "forbidden", "building", "barrier"}  # fmt: skip
_TAGS = ("building", "barrier", "obstacle", "wall")
_YES: tuple[object, ...] = ("yes", True)
# Of agents, in runs that were exported: no part of a map.
TRAJECTORY = "trajectory"
_DEPTH = {
    "Point": 0,
    "MultiPoint": 1,
    "LineString": 1,
    "MultiLineString": 2,
    "Polygon": 2,
    "MultiPolygon": 3,
}


def read_geojson(file: FileContent, options: FileOptions, beside: Beside) -> Drawing:
    """Every feature; kinds are what `floor` and `layers` choose from."""
    del beside
    tree = read_json_tree(file.content)
    floors: list[Any] = []
    blocked: list[Any] = []
    walls: list[FloatArray] = []
    spots: dict[str, Point] = {}
    kinds: dict[str, None] = {}
    left = 0
    for kind, shape in _features(tree):
        kinds.setdefault(kind or "unnamed")
        if kind == TRAJECTORY:
            left += 1
            continue
        if shape.geom_type == "Point":
            spots[kind or f"p{len(spots) + 1}"] = (shape.x, shape.y)
            continue
        is_floor = kind in options.floor if options.floor else (
            shape.geom_type == "Polygon" and kind.lower() not in _BLOCKING and kind not in options.layers
        )  # fmt: skip
        if not is_floor and options.layers and kind not in options.layers:
            left += 1
        elif shape.geom_type == "LineString":
            walls.append(np.asarray(shapely.get_coordinates(shape)))
        else:
            (floors if is_floor else blocked).append(shape)
    whole, mended = repaired(floors, "polygons")
    cut, more = repaired(blocked, "obstacles", blocked=True)
    if left:
        more += (f"{left} shapes of other kinds were left out",)
    drawing = Drawing(
        floors=whole, blocked=cut, walls=tuple(walls), spots=spots, names=tuple(kinds),
        mended=mended + more,
    )  # fmt: skip
    return drawing if options.scale is not None else _projected(drawing)


def _features(tree: dict[str, Any]) -> Iterator[tuple[str, shapely.Geometry]]:
    """(kind, polygon, line or point) of all features."""
    features = [tree]
    if tree.get("type") == "FeatureCollection":
        features = members(tree, "features")
    count = 0
    for k, feature in enumerate(features):
        path = f"features[{k}]"
        if not isinstance(feature, dict):
            raise FormatError(f"{path} is no object")
        geometry = feature.get("geometry") if feature.get("type") == "Feature" else feature
        if geometry is None:
            continue
        properties = feature.get("properties")
        given = properties if isinstance(properties, dict) else {}
        kind = next((given[key] for key in _KINDS if isinstance(given.get(key), str)), "")
        # As OpenStreetMap has it: `building: yes`.
        kind = kind or next((key for key in _TAGS if given.get(key) in _YES), "")
        for shape in _shapes(geometry, path):
            count += 1
            if count > MOST_SHAPES:
                raise FormatError(f"has more than {MOST_SHAPES} shapes")
            yield kind, shape


def _shapes(geometry: Any, path: str) -> Iterator[shapely.Geometry]:
    """The single shapes of a geometry."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind == "GeometryCollection":
        for k, part in enumerate(members(geometry, "geometries", f"{path}.")):
            if isinstance(part, dict) and part.get("type") == "GeometryCollection":
                raise FormatError(f"{path} holds a collection inside a collection")
            yield from _shapes(part, f"{path}.geometries[{k}]")
        return
    if kind not in _DEPTH:
        raise FormatError(f"{path} has a geometry of the type {str(kind)[:40]!r}")
    many = kind.startswith("Multi")
    coordinates = geometry.get("coordinates")
    if not isinstance(coordinates, list):
        raise FormatError(f"{path} has no coordinates")
    for one in coordinates if many else [coordinates]:
        single = kind.removeprefix("Multi")
        if single == "Point":
            yield shapely.Point(place(one, path))
        elif single == "LineString":
            yield shapely.LineString(_line(one, path, 2))
        else:
            if not isinstance(one, list) or not one:
                raise FormatError(f"{path} has a polygon without rings")
            outer, *holes = [_line(ring, path, 4) for ring in one]
            yield shapely.Polygon(outer, holes)


def _line(value: Any, path: str, least: int) -> list[Point]:
    if not isinstance(value, list) or len(value) < least:
        raise FormatError(f"{path} has a line or ring of fewer than {least} places")
    return [place(one, path) for one in value]


def _projected(drawing: Drawing) -> Drawing:
    """Degrees -> m around the middle of the file."""
    shapes = np.array([*drawing.shapes, *map(shapely.Point, drawing.spots.values())], dtype=object)
    if not len(shapes):
        raise FormatError("holds no shape")
    west, south, east, north = shapely.total_bounds(shapes).tolist()
    if max(-west, east) > 180 or max(-south, north) > 90:
        raise FormatError(
            "has coordinates that are no degrees, which GeoJSON means; say map.scale: 1 where they are metres"
        )
    pyproj = require("pyproj", "GeoJSON in degrees (map.scale: 1 reads it as metres)", "maps")
    plane = pyproj.Proj(
        proj="aeqd", lon_0=(west + east) / 2, lat_0=(south + north) / 2, ellps="WGS84"
    )

    def place_of(points: FloatArray) -> FloatArray:
        return np.column_stack(plane(points[:, 0], points[:, 1]))

    def spot(at: Point) -> Point:
        x, y = place_of(np.array([at]))[0].tolist()
        return x, y

    return replace(
        drawing,
        floors=tuple(shapely.transform(shape, place_of) for shape in drawing.floors),
        blocked=tuple(shapely.transform(shape, place_of) for shape in drawing.blocked),
        walls=tuple(place_of(line) for line in drawing.walls),
        spots={name: spot(at) for name, at in drawing.spots.items()},
    )


def _claims(content: bytes) -> bool:
    head = content[:4096]
    return b'"FeatureCollection"' in head or b'"Feature"' in head or b'"coordinates"' in head


GEOJSON = ForeignFormat(
    "GeoJSON file", (".geojson", ".json"), read_geojson, frozenset({"layers", "floor"}), _claims
)
