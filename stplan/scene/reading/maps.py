"""The map of a scene file -> `MapSpec`, with every fault its shapes can have. Lengths in m."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stplan.scene.format.file import MapFile, ObstacleFile
from stplan.scene.model import (
    CircleObstacle,
    MapSpec,
    MeshBase,
    Point,
    PolygonBase,
    PolygonObstacle,
)
from stplan.scene.reading.faults import Fault

MESH_SUFFIXES = (".obj", ".ply", ".off", ".stl", ".glb")
LARGEST_MESH = 100 * 1024 * 1024


def compile_map(entry: MapFile, directory: Path, faults: list[Fault]) -> MapSpec:
    """The map; with new `faults` it must not be used. Mesh paths are relative to `directory`."""
    _exactly_one(entry, ("mesh", "polygon", "rectangle"), "map", faults)
    if entry.holes is not None and entry.polygon is None:
        faults.append(
            ("map.holes", "belongs to a polygon; with other bases, obstacles do the same")
        )
    if entry.up is not None and entry.mesh is None:
        faults.append(("map.up", "belongs to a mesh, and there is none"))
    base: MeshBase | PolygonBase
    if entry.mesh is not None:
        base = MeshBase(_mesh_path(entry.mesh, directory, faults), entry.up or "z")
    elif entry.polygon is not None:
        base = _polygon_base(entry.polygon, entry.holes or [], faults)
    else:
        base = PolygonBase(_rectangle(entry.rectangle or [0, 0, 1, 1], "map.rectangle", faults))
    obstacles = tuple(
        _obstacle(obstacle, f"map.obstacles[{k}]", faults)
        for k, obstacle in enumerate(entry.obstacles or [])
    )
    return MapSpec(base, obstacles, entry.resolution)


def _exactly_one(entry: Any, keys: tuple[str, ...], path: str, faults: list[Fault]) -> None:
    given = [key for key in keys if getattr(entry, key) is not None]
    if len(given) != 1:
        *most, last = keys
        found = " and ".join(given) or "none"
        faults.append((path, f"has {found} of {', '.join(most)} and {last}; one is expected"))


def _mesh_path(text: str, directory: Path, faults: list[Fault]) -> Path:
    path = directory / text
    fault = ""
    try:
        if Path(text).is_absolute():
            fault = f"is {text!r}, an absolute path; one relative to the scene file is expected"
        elif "\x00" in text or not path.exists():
            fault = f"there is no file {text!r} beside the scene"
        elif not path.is_file():
            fault = f"{text!r} is no regular file; a mesh file is expected"
        elif path.stat().st_size > LARGEST_MESH:
            fault = f"{text!r} is larger than {LARGEST_MESH // 2**20} MiB"
    except OSError as error:
        fault = f"{text[:100]!r} cannot be read: {error.strerror}"
    if not fault and path.suffix.lower() not in MESH_SUFFIXES:
        fault = f"is {text!r}; a file that ends in {', '.join(MESH_SUFFIXES)} is expected"
    if fault:
        faults.append(("map.mesh", fault))
    return path


def _rectangle(values: list[float], path: str, faults: list[Fault]) -> tuple[Point, ...]:
    x0, y0, x1, y1 = values
    for axis, low, high in (("x", x0, x1), ("y", y0, y1)):
        if low >= high:
            faults.append(
                (
                    path,
                    f"reaches from {axis}min {low:g} to {axis}max {high:g}; "
                    f"[xmin, ymin, xmax, ymax] with {axis}min < {axis}max is expected",
                )
            )
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def _ring(points: list[list[float]], path: str, faults: list[Fault]) -> tuple[Point, ...]:
    """The corners, once each: a ring may be written closed."""
    import shapely

    ring = tuple((point[0], point[1]) for point in points)
    if ring[0] == ring[-1]:
        ring = ring[:-1]
    if len(set(ring)) < 3:
        faults.append(
            (path, f"has {len(set(ring))} distinct points; a ring of at least 3 is expected")
        )
        return ring
    shape = shapely.Polygon(ring)
    if not shape.is_valid:
        reason = shapely.is_valid_reason(shape)
        faults.append((path, f"crosses or touches itself ({reason}); a simple ring is expected"))
    elif shape.area == 0:
        faults.append((path, "has no area; corners that are not on one line are expected"))
    return ring


def _polygon_base(
    outer: list[list[float]], holes: list[list[list[float]]], faults: list[Fault]
) -> PolygonBase:
    import shapely

    before = len(faults)
    base = PolygonBase(
        _ring(outer, "map.polygon", faults),
        tuple(_ring(hole, f"map.holes[{k}]", faults) for k, hole in enumerate(holes)),
    )
    if len(faults) == before and holes:
        shape = shapely.Polygon(base.outer, base.holes)
        if not shape.is_valid:
            reason = shapely.is_valid_reason(shape)
            faults.append(
                ("map.holes", f"({reason}); holes inside the polygon, apart, are expected")
            )
    return base


def _obstacle(
    entry: ObstacleFile, path: str, faults: list[Fault]
) -> PolygonObstacle | CircleObstacle:
    _exactly_one(entry, ("rectangle", "polygon", "circle"), path, faults)
    if entry.circle is not None:
        x, y = entry.circle.center
        return CircleObstacle((x, y), entry.circle.radius)
    if entry.polygon is not None:
        return PolygonObstacle(_ring(entry.polygon, f"{path}.polygon", faults))
    return PolygonObstacle(_rectangle(entry.rectangle or [0, 0, 1, 1], f"{path}.rectangle", faults))
