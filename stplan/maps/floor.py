"""A map as written -> the area that is left to move in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.obstacles import LineObstacle, Obstacle
from stplan.maps.reader import Floor, MapError, Note
from stplan.maps.repair import mended, nonzero
from stplan.maps.spec import MapSpec


def read_floor(spec: MapSpec, radius: float | None = None) -> Floor:
    """The area of the map's base less the obstacles, m.

    Args:
        radius: of the smallest agent, m: far narrower cracks of a mesh may be closed.

    Raises:
        MapError: a file of the map cannot be used, or nothing is left.
    """
    base = spec.base.floor_for(radius)
    area = base.area
    lines = [one for one in spec.obstacles if isinstance(one, LineObstacle)]
    thin = tuple(np.array(one.line) for one in lines if one.thickness is None)
    notes = base.notes
    if len(thin) < len(spec.obstacles):
        covered, more = _covered(spec.obstacles)
        notes += more
        # One cut is a hundred times faster than one for each.
        area = shapely.difference(area, covered)
    refused = [note for note in notes if note.mending and not spec.repair]
    if refused:
        raise MapError(refused[0].path, f"{refused[0].text}; map.repair: true mends it")
    parts = [p for p in shapely.get_parts(area) if isinstance(p, shapely.Polygon) and p.area > 0]
    if not parts:
        raise MapError("map", "has no area left to move in")
    area = parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)
    return replace(base, area=area, slits=_inside(area, (*base.slits, *thin)), notes=notes)


def _covered(obstacles: Sequence[Obstacle]) -> tuple[shapely.Geometry, tuple[Note, ...]]:
    """The union of all obstacles that have an area, and notes on those that had to be mended."""
    rings = [(k, one) for k, one in enumerate(obstacles) if not isinstance(one, LineObstacle)]
    shapes = polygons([one.outline() for _, one in rings])
    notes: list[Note] = []
    for bad in np.flatnonzero(~shapely.is_valid(shapes) | (shapely.area(shapes) == 0)).tolist():
        number, one = rings[bad]
        outline = [(x, y) for x, y in one.outline().tolist()]
        shapes[bad], own = mended(outline, f"map.obstacles[{number}]", nonzero)
        notes += own
    walls = [
        _wall(np.array(one.line), one.thickness)
        for one in obstacles
        if isinstance(one, LineObstacle) and one.thickness is not None
    ]
    return shapely.disjoint_subset_union_all(np.append(shapes, walls)), tuple(notes)


def _wall(line: FloatArray, thickness: float) -> shapely.Geometry:
    """A wall along a polyline (n, 2): square corners, flat ends, none where the line is closed."""
    closed = len(line) > 3 and (line[0] == line[-1]).all()
    shape = shapely.linearrings(line) if closed else shapely.linestrings(line)
    return shapely.buffer(shape, thickness / 2, cap_style="flat", join_style="mitre")


def _inside(area: shapely.Geometry, lines: Sequence[FloatArray]) -> tuple[FloatArray, ...]:
    """The parts of polylines (n, 2) in `area`, less what runs along its boundary."""
    if not lines:
        return ()
    shapes = polylines(lines)
    shapely.prepare(area)
    whole = shapely.contains_properly(area, shapes)
    inner = shapely.intersection(shapes[~whole], area)
    inner = shapely.difference(inner, shapely.boundary(area))
    return tuple(line for line, kept in zip(lines, whole, strict=True) if kept) + pieces(inner)


def polylines(lines: Sequence[FloatArray]) -> FloatArray:
    """(L,) shapes of polylines (n, 2), n >= 2."""
    if not lines:
        return np.empty(0, dtype=object)
    owners = np.repeat(np.arange(len(lines)), list(map(len, lines)))
    return np.asarray(shapely.linestrings(np.vstack(lines), indices=owners))


def pieces(shapes: FloatArray) -> tuple[FloatArray, ...]:
    """The polylines (n, 2) that `shapes` (L,) consist of; points among them are dropped."""
    parts = shapely.get_parts(shapes)
    return tuple(shapely.get_coordinates(part) for part in parts if shapely.length(part) > 0)


def polygons(rings: Sequence[FloatArray]) -> FloatArray:
    """(R,) polygons of rings of corners (n, 2), n >= 3."""
    if not rings:
        return np.empty(0, dtype=object)
    owners = np.repeat(np.arange(len(rings)), list(map(len, rings)))
    return np.asarray(shapely.polygons(shapely.linearrings(np.vstack(rings), indices=owners)))
