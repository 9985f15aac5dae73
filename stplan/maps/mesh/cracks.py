"""The union of triangles without the cracks that rounding and careless export leave between them.

Where a corner of one triangle lies on the side of another, or corners that were meant to be one were
written differently, a crack may stay open that is far narrower than anything real: it would be a wall
that nobody sees. Such corners are made part of both triangles. Nothing else is moved, and nothing
further than the tolerance: a rounding always, and what the map may be welded within where there are
wider cracks than that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from stplan.arrays import FloatArray, IntArray
from stplan.errors import SceneError

# Cracks up to this share of the map's extent are closed: single precision (STL, GLB) and text of six
# decimals carry no more.
CRACK = 1e-6
# So many corners may be as close as a crack to each, on average; a few corners to more.
MOST_NEIGHBOURS = 100
MOST_PAIRS = 4_000_000
# Areas this close, as a share, differ by rounding.
SAME_AREA = 1e-12


@dataclass(frozen=True)
class Joined:
    """The union of a mesh's triangles.

    Attributes:
        num_welded: corners wider apart than a rounding that were joined to another corner or a side.
        widest: the furthest that one of them was off, m.
    """

    area: shapely.Geometry
    num_welded: int = 0
    widest: float = 0.0


def joined(vertices: FloatArray, triangles: IntArray, within: float = 0.0) -> Joined:
    """The union of `triangles` (F, 3) of `vertices` (V, 2), cracks up to `within` (m) closed.

    Cracks that rounding explains are closed always.

    Raises:
        SceneError: they are too tangled; the message goes after the name of what they are from.
    """
    triangles = _distinct(triangles)
    width = CRACK * float(np.ptp(vertices[triangles.ravel()], axis=0).max())
    triangles, _ = _merged(vertices, triangles, width)
    reach, moved = max(width, within), np.empty(0)
    if within > width:
        triangles, moved = _merged(vertices, triangles, within, apart=True)
    hanging, off = _hanging(vertices, triangles, reach)
    offsets = np.concatenate([moved, off[off > width]])
    if len(offsets):
        width = reach
    shapes = shapely.polygons(vertices[triangles])
    rings = _with_corners(vertices, triangles, hanging)
    for owner, ring in list(rings.items()):
        shape = shapely.Polygon(vertices[ring])
        if shape.is_valid:
            shapes[owner] = shape
        else:
            del rings[owner]
    whole = _outlined(vertices, triangles, rings, shapes)
    area = _without_slivers(shapely.union_all(shapes) if whole is None else whole, width)
    return Joined(area, len(offsets), float(offsets.max(initial=0.0)))


def _without_slivers(area: shapely.Geometry, width: float) -> shapely.Geometry:
    """`area` with those holes filled that are nowhere wider than `width` (m): cracks between faces."""
    parts = shapely.get_parts(area)
    parts = parts[shapely.get_dimensions(parts) == 2]
    holes = shapely.polygons(shapely.get_rings(parts[shapely.get_num_interior_rings(parts) > 0]))
    # No ring encloses more than its length times the radius of the largest disc in it.
    thin = holes[shapely.area(holes) <= width / 2 * shapely.length(holes)]
    thin = thin[shapely.is_empty(shapely.buffer(thin, -width / 2))]
    if not len(thin):
        return area
    narrow = {hole.exterior.wkb for hole in thin}
    whole = [
        shapely.Polygon(part.exterior, [ring for ring in part.interiors if ring.wkb not in narrow])
        for part in parts
    ]
    return whole[0] if len(whole) == 1 else shapely.MultiPolygon(whole)


def _distinct(triangles: IntArray) -> IntArray:
    """`triangles` (F, 3) without twins, which would hide the rim of each other."""
    sorted_ones = np.sort(triangles, axis=1)
    order = np.lexsort(sorted_ones.T)
    new = np.ones(len(order), dtype=bool)
    new[1:] = (np.diff(sorted_ones[order], axis=0) != 0).any(axis=1)
    return triangles[np.sort(order[new])]


def _outlined(
    vertices: FloatArray, triangles: IntArray, rings: dict[int, list[int]], shapes: FloatArray
) -> shapely.Geometry | None:
    """The union of `shapes` (F,), triangles or `rings` in their place, made of the sides of only one.

    None where they do more than touch along whole sides: the result then crosses or touches itself, or
    has another area than all of them together. (To ask whether they are a valid coverage takes minutes
    for some thousand slender triangles, to unite them takes ten times as long.)
    """
    plain = np.ones(len(triangles), dtype=bool)
    plain[list(rings)] = False
    sides = [triangles[plain][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)]
    sides += [np.column_stack([ring, np.roll(ring, -1)]) for ring in rings.values()]
    ends = np.vstack(sides)
    lines = shapely.linestrings(vertices[ends[_alone(ends)]])
    faces = shapely.get_parts(shapely.polygonize(lines))
    covered, _ = shapely.STRtree(shapes).query(shapely.point_on_surface(faces), "intersects")
    faces = faces[np.unique(covered)]
    whole = faces[0] if len(faces) == 1 else shapely.multipolygons(faces)
    area = float(shapely.area(shapes).sum())
    exact = abs(shapely.area(whole) - area) <= SAME_AREA * area and shapely.is_valid(whole)
    return whole if exact else None


def _alone(sides: IntArray) -> IntArray:
    """Which of `sides` (S, 2) occur once, in either direction, rising."""
    low, high = sides.min(axis=1), sides.max(axis=1)
    order = np.lexsort((high, low))
    same = (np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)
    alone = np.ones(len(sides), dtype=bool)
    alone[order[1:][same]] = False
    alone[order[:-1][same]] = False
    return np.flatnonzero(alone)


def _rim(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Sides (E, 2) that only one triangle has, and that triangle (E,): cracks run along these."""
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    alone = _alone(sides)
    return sides[alone], alone // 3


def _merged(
    vertices: FloatArray, triangles: IntArray, width: float, *, apart: bool = False
) -> tuple[IntArray, FloatArray]:
    """`triangles` with corners on the rim at most `width` (m) apart made one of them.

    Args:
        apart: whether corners that short sides link are left as they are: a detail of the drawing.

    Returns:
        What becomes of the triangles, those that collapse left out; how far corners were moved, m.

    Raises:
        SceneError: there are too many corners in almost the same place.
    """
    sides, _ = _rim(triangles)
    rim = np.unique(sides)
    tree = cKDTree(vertices[rim])
    if tree.count_neighbors(tree, width) > max(MOST_NEIGHBOURS * len(rim), MOST_PAIRS):
        if (
            apart
        ):  # Details far finer than the tolerance: nothing to weld, or nothing to be sure of.
            return triangles, np.empty(0)
        raise SceneError("has many corners in almost the same place")
    pairs = rim[tree.query_pairs(width, output_type="ndarray")].reshape(-1, 2)
    if apart:
        detail = _details(vertices, triangles, width)
        pairs = pairs[detail[pairs[:, 0]] != detail[pairs[:, 1]]]
    if not len(pairs):
        return triangles, np.empty(0)
    stand_in = _stand_ins(vertices, triangles, pairs, width)
    moved = np.flatnonzero(stand_in != np.arange(len(vertices)))
    triangles = stand_in[triangles]
    a, b, c = triangles.T
    return (
        triangles[(a != b) & (b != c) & (c != a)],
        np.hypot(*(vertices[moved] - vertices[stand_in[moved]]).T),
    )


def _details(vertices: FloatArray, triangles: IntArray, width: float) -> IntArray:
    """(V,) a number for every vertex: the same where sides up to `width` (m) long link them."""
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    length = np.hypot(*(vertices[sides[:, 1]] - vertices[sides[:, 0]]).T)
    return _groups(sides[length <= width], len(vertices))


def _groups(links: IntArray, count: int) -> IntArray:
    """(count,) which of the connected components that `links` (L, 2) make each of so many is in."""
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    group: IntArray = connected_components(graph, directed=False)[1].astype(np.int64)
    return group


def _stand_ins(
    vertices: FloatArray, triangles: IntArray, pairs: IntArray, width: float
) -> IntArray:
    """(V,) for every vertex one at most `width` (m) from it: the same for all of a cluster of `pairs`."""
    group = _groups(pairs, len(vertices))
    _, first = np.unique(group, return_index=True)
    stand_in = first[group]
    far = np.hypot(*(vertices - vertices[stand_in]).T) > width
    folded = stand_in[triangles]
    folded = (folded == np.roll(folded, 1, axis=1)) & (triangles != np.roll(triangles, 1, axis=1))
    loose = np.isin(group, np.union1d(group[far], group[triangles[folded]]))
    if loose.any():
        stand_in[loose] = np.flatnonzero(loose)
        for vertex, other in _clusters(
            vertices, triangles, pairs[loose[pairs[:, 0]]], width
        ).items():
            stand_in[vertex] = other
    return stand_in


def _clusters(
    vertices: FloatArray, triangles: IntArray, pairs: IntArray, width: float
) -> dict[int, int]:
    """What stands in for the vertices of `pairs` (P, 2) that make long chains: the closest join first.

    No vertex is moved further than `width` (m), and no two of one triangle become one.
    """
    members: dict[int, list[int]] = {vertex: [vertex] for vertex in np.unique(pairs).tolist()}
    home = {vertex: vertex for vertex in members}
    inside = np.isin(triangles, pairs).sum(axis=1) > 1
    around: dict[int, set[int]] = {vertex: set() for vertex in members}
    for triangle in triangles[inside].tolist():
        for vertex in triangle:
            if vertex in around:
                around[vertex].update(triangle)
    pairs = np.sort(pairs, axis=1)
    distance = np.hypot(*(vertices[pairs[:, 1]] - vertices[pairs[:, 0]]).T)
    for head, tail in pairs[np.lexsort((pairs[:, 1], pairs[:, 0], distance))].tolist():
        into, gone = sorted((home[head], home[tail]))
        if into == gone or not around[into].isdisjoint(members[gone]):
            continue
        if np.hypot(*(vertices[members[gone]] - vertices[into]).T).max() > width:
            continue
        members[into] += members[gone]
        around[into] |= around[gone]
        for vertex in members.pop(gone):
            home[vertex] = into
    return home


def _hanging(
    vertices: FloatArray, triangles: IntArray, width: float
) -> tuple[IntArray, FloatArray]:
    """Where a vertex of the rim lies on a side of a triangle not its own, `width` (m) off at most.

    Returns:
        Rows (H, 4) of that triangle, the ends of its side, and the vertex; how far off they are (H,), m.
    """
    sides, owners = _rim(triangles)
    rim = np.unique(sides)
    lines = shapely.linestrings(vertices[sides])
    points = shapely.points(vertices[rim])
    tree = shapely.STRtree(lines)
    point, side = tree.query(points, predicate="dwithin", distance=width)
    foreign = (triangles[owners[side]] != rim[point][:, None]).all(axis=1)
    point, side = point[foreign], side[foreign]
    # In an acute corner a vertex may be near two sides of one triangle; it hangs on the nearer.
    distance = shapely.distance(points[point], lines[side])
    order = np.lexsort((side, distance, rim[point], owners[side]))
    point, side, distance = point[order], side[order], distance[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (np.diff(owners[side]) != 0) | (np.diff(point) != 0)
    point, side, distance = point[new], side[new], distance[new]
    return np.column_stack([owners[side], sides[side], rim[point]]), distance


def _with_corners(
    vertices: FloatArray, triangles: IntArray, hanging: IntArray
) -> dict[int, list[int]]:
    """The rings of triangles that vertices hang on (rows of `_hanging`), with these among their corners."""
    on_side: dict[tuple[int, int, int], list[int]] = {}
    for owner, head, tail, vertex in hanging.tolist():
        on_side.setdefault((owner, head, tail), []).append(vertex)
    on_owner: dict[int, dict[tuple[int, int], list[int]]] = {}
    for (owner, head, tail), corners in on_side.items():
        along = (vertices[corners] - vertices[head]) @ (vertices[tail] - vertices[head])
        in_order = [corners[k] for k in np.argsort(along, kind="stable").tolist()]
        on_owner.setdefault(owner, {})[head, tail] = in_order
    rings = {}
    for owner, inserted in on_owner.items():
        a, b, c = triangles[owner].tolist()
        rings[owner] = [
            k for side in ((a, b), (b, c), (c, a)) for k in (side[0], *inserted.get(side, ()))
        ]
    return rings
