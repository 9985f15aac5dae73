"""Rings that cross, touch or retrace themselves -> the area they enclose, and what was wrong with them.

A ring winds around every place a whole number of times. Where that is not once, the drawing is in doubt,
and the place is never free: the outside of a map is where its ring winds an even number of times around
(the even-odd rule), and what is cut out is wherever a ring winds around at all (the nonzero rule). Where
a ring runs there and back it encloses nothing: such spikes, and bridges to holes, are no walls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from stplan.amounts import place
from stplan.arrays import BoolArray, FloatArray, IntArray, Point
from stplan.maps.reader import Floor, MapError, Note

# So many places are named.
NAMED_PLACES = 3
# Winding numbers are counted for so many pairs of a face and an edge at once.
_AT_ONCE = 10_000_000

# Winding numbers (F,) -> which of these faces belong to the area.
Rule = Callable[[IntArray], BoolArray]


def even_odd(winding: IntArray) -> BoolArray:
    """Of a base: what its ring goes around an odd number of times."""
    return winding % 2 == 1


def nonzero(winding: IntArray) -> BoolArray:
    """Of what is cut out: whatever its ring goes around."""
    return winding != 0


@dataclass(frozen=True)
class Enclosed:
    """What a ring encloses.

    Attributes:
        area: valid, empty where the ring encloses nothing.
        faults: what is wrong with the ring and where, in words; none where it is simple.
    """

    area: shapely.Geometry
    faults: tuple[str, ...] = ()


def enclosed(ring: FloatArray, rule: Rule) -> Enclosed:
    """The area that a ring of corners (n, 2), n >= 3, not closed, encloses by `rule`."""
    simple = shapely.Polygon(ring)
    if shapely.is_valid(simple):
        return Enclosed(simple)
    lines = shapely.union_all([shapely.linearrings(ring)])
    found, cuts, dangles, _ = shapely.polygonize_full([lines])
    faces = shapely.get_parts(found)
    winding = _winding(ring, shapely.get_coordinates(shapely.point_on_surface(faces)))
    area = shapely.coverage_union_all(faces[rule(winding)])
    if not shapely.is_valid(area):
        area = shapely.union_all(faces[rule(winding)])
    retraced = shapely.get_parts(shapely.line_merge(shapely.union_all([cuts, dangles])))
    faults = []
    if len(retraced):
        ends = [f"from {_end(line, 0)} to {_end(line, -1)}" for line in retraced]
        faults.append(f"runs there and back {_some(ends)}")
    contacts = _contacts(faces)
    if len(contacts):
        faults.append(f"touches or crosses itself at {_some([place(*at) for at in contacts])}")
    return Enclosed(area, tuple(faults) or ("touches itself",))


def whole_shape(shape: shapely.Geometry, *, blocked: bool) -> Enclosed:
    """A polygon, or several, with rings that may not be simple, and their holes.

    Args:
        blocked: whether the shape is in the way: its rings are then read by the nonzero rule, and its
            holes, where one could go, by the even-odd rule; the other way round where it is floor.
    """
    outer, inner = (nonzero, even_odd) if blocked else (even_odd, nonzero)
    areas, faults = [], []
    for part in shapely.get_parts(shape):
        if not isinstance(part, shapely.Polygon) or part.is_empty:
            continue
        base = enclosed(shapely.get_coordinates(part.exterior)[:-1], outer)
        holes = [enclosed(shapely.get_coordinates(ring)[:-1], inner) for ring in part.interiors]
        areas.append(shapely.difference(base.area, shapely.union_all([one.area for one in holes])))
        faults += [fault for one in (base, *holes) for fault in one.faults]
    return Enclosed(shapely.union_all(areas), tuple(faults))


def _winding(ring: FloatArray, points: FloatArray) -> IntArray:
    """How many times `ring` (n, 2) goes around each of `points` (P, 2) off it, counterclockwise."""
    tail, head = ring, np.roll(ring, -1, axis=0)
    counts = np.zeros(len(points), dtype=np.int64)
    step = max(1, _AT_ONCE // len(ring))
    for begin in range(0, len(points), step):
        x, y = points[begin : begin + step].T[..., None]
        above_tail, above_head = tail[:, 1] > y, head[:, 1] > y
        side = (head[:, 0] - tail[:, 0]) * (y - tail[:, 1]) - (x - tail[:, 0]) * (
            head[:, 1] - tail[:, 1]
        )
        rising = ~above_tail & above_head & (side > 0)
        falling = above_tail & ~above_head & (side < 0)
        counts[begin : begin + step] = rising.sum(axis=1) - falling.sum(axis=1)
    return counts


def _contacts(faces: FloatArray) -> FloatArray:
    """(K, 2) corners where more than two edges of `faces` (F,) meet."""
    ends = np.vstack([_edges(ring) for ring in shapely.get_rings(faces)] or [np.empty((0, 4))])
    # Two faces may have an edge in common, and draw it in opposite directions.
    forward = (ends[:, :2] < ends[:, 2:])[:, 0] | (
        (ends[:, 0] == ends[:, 2]) & (ends[:, 1] < ends[:, 3])
    )
    ends = np.unique(np.where(forward[:, None], ends, ends[:, [2, 3, 0, 1]]), axis=0)
    corners, degree = np.unique(ends.reshape(-1, 2), axis=0, return_counts=True)
    contacts = corners[degree > 2]
    # What should be 0 is computed to a rounding of the largest coordinates.
    return np.where(np.abs(contacts) < 1e-12 * np.abs(corners).max(initial=0), 0.0, contacts)


def _edges(ring: shapely.LinearRing) -> FloatArray:
    corners = shapely.get_coordinates(ring)
    return np.hstack([corners[:-1], corners[1:]])


def _end(line: shapely.LineString, k: int) -> str:
    return place(*line.coords[k])


def _some(texts: list[str]) -> str:
    """All of a few texts, the first of many."""
    named, more = texts[:NAMED_PLACES], len(texts) - NAMED_PLACES
    if more > 0:
        return f"{', '.join(named)} and {more} more places"
    return " and ".join(part for part in (", ".join(named[:-1]), named[-1]) if part)


def without_holes(outer: Sequence[Point], holes: Sequence[Sequence[Point]]) -> Floor:
    """What an outer ring encloses less what its holes do, with notes on all that is not simple.

    Raises:
        MapError: the outer ring or a hole encloses nothing.
    """
    base, base_notes = mended(outer, "map.polygon", even_odd)
    notes = list(base_notes)
    cut = []
    shapely.prepare(base)
    for k, hole in enumerate(holes):
        path = f"map.holes[{k}]"
        area, own = mended(hole, path, nonzero)
        notes += own
        cut.append(area)
        if not shapely.intersects(base, area) or shapely.touches(base, area):
            notes.append(Note(path, "lies outside the polygon", "it cuts nothing"))
        elif not shapely.contains_properly(base, area):
            where = _somewhere(shapely.intersection(area, base.boundary))
            text = f"reaches the edge of the polygon at {where}"
            notes.append(Note(path, text, "cut out as `obstacles` are"))
    for first, second in _overlaps(cut):
        where = _somewhere(shapely.intersection(cut[first], cut[second]))
        text = f"meets map.holes[{first}] at {where}"
        notes.append(Note(f"map.holes[{second}]", text, "the two are cut out as one"))
    return Floor(shapely.difference(base, shapely.union_all(cut)), notes=tuple(notes))


def mended(
    ring: Sequence[Point], path: str, rule: Rule
) -> tuple[shapely.Geometry, tuple[Note, ...]]:
    """The area that a ring encloses, and a note where it is not simple.

    Raises:
        MapError: it encloses nothing.
    """
    found = enclosed(np.array(ring), rule)
    if found.area.area == 0:
        raise MapError(path, "has no area; corners that are not on one line are expected")
    if not found.faults:
        return found.area, ()
    return found.area, (Note(path, "; ".join(found.faults), f"mended: {_MEANT[rule]}"),)


_MEANT: dict[Rule, str] = {
    even_odd: "inside is what it goes around an odd number of times",
    nonzero: "cut out is all that it goes around",
}


def _overlaps(areas: list[shapely.Geometry]) -> list[tuple[int, int]]:
    """Pairs of areas that meet in more than a point, rising."""
    shapes = np.array([*areas, None], dtype=object)[:-1]
    pairs = shapely.STRtree(shapes).query(shapes, predicate="intersects").T
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    common = shapely.intersection(shapes[pairs[:, 0]], shapes[pairs[:, 1]])
    wide = (shapely.get_dimensions(common) > 0) | (shapely.get_num_geometries(common) > 1)
    return [(first, second) for first, second in np.unique(pairs[wide], axis=0).tolist()]


def _somewhere(shape: shapely.Geometry) -> str:
    return place(*shapely.get_coordinates(shapely.point_on_surface(shape))[0].tolist())
