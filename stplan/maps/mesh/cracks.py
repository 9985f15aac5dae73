"""The union of triangles without the cracks that rounding leaves between them.

Where a corner of one triangle lies on the side of another, or two corners that were meant to be one
were written differently, a crack may stay open that is far narrower than anything real: it would be
a wall that nobody sees. Such corners are made part of both triangles. Nothing else is moved.
"""

from __future__ import annotations

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
# So many corners may be as close as a crack to each, on average.
MOST_NEIGHBOURS = 100
# Areas this close, as a share, differ by rounding.
SAME_AREA = 1e-12


def joined(vertices: FloatArray, triangles: IntArray) -> shapely.Geometry:
    """The union of `triangles` (F, 3) of `vertices` (V, 2), cracks closed.

    Raises:
        SceneError: they are too tangled; the message goes after the name of what they are from.
    """
    width = CRACK * float(np.ptp(vertices[triangles.ravel()], axis=0).max())
    sides, owners = _rim(triangles)
    triangles = _merged(vertices, np.unique(sides), triangles, width)
    shapes = shapely.polygons(vertices[triangles])
    sides, owners = _rim(triangles)
    hanging = _hanging(vertices, sides, owners, triangles, width)
    for owner, ring in _with_corners(vertices, triangles, sides, owners, hanging).items():
        shape = shapely.Polygon(vertices[ring])
        if shape.is_valid:
            shapes[owner] = shape
    return _without_slivers(_union(shapes), width)


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


def _union(shapes: FloatArray) -> shapely.Geometry:
    """The union of polygons, fast and exact where they only touch along whole sides.

    Whether they do shows in the result: where polygons overlap or sides match in part, it crosses
    or touches itself, or has another area than all of them together. (To ask whether they are a
    valid coverage takes minutes for some thousand slender triangles.)
    """
    try:
        whole = shapely.coverage_union_all(shapes)
    except shapely.errors.GEOSException:
        return shapely.union_all(shapes)
    area = float(shapely.area(shapes).sum())
    if abs(shapely.area(whole) - area) <= SAME_AREA * area and shapely.is_valid(whole):
        return whole
    return shapely.union_all(shapes)


def _rim(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Sides (E, 2) that only one triangle has, and that triangle (E,): cracks run along these."""
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, first, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True
    )
    alone = np.sort(first[count == 1])
    return sides[alone], alone // 3


def _merged(vertices: FloatArray, rim: IntArray, triangles: IntArray, width: float) -> IntArray:
    """`triangles` with vertices of the `rim` at most `width` (m) apart made the first of them."""
    tree = cKDTree(vertices[rim])
    if tree.count_neighbors(tree, width) > MOST_NEIGHBOURS * len(rim):
        raise SceneError("has many corners in almost the same place")
    pairs = tree.query_pairs(width, output_type="ndarray")
    if not len(pairs):
        return triangles
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(rim),) * 2)
    _, group = connected_components(links, directed=False)
    _, first = np.unique(group, return_index=True)
    stand_in = np.arange(len(vertices))
    stand_in[rim] = rim[first[group]]
    triangles = stand_in[triangles]
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def _hanging(
    vertices: FloatArray, sides: IntArray, owners: IntArray, triangles: IntArray, width: float
) -> IntArray:
    """Pairs (side, vertex) where a vertex of the rim lies on a side of a triangle not its own."""
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
    point, side = point[order], side[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (np.diff(owners[side]) != 0) | (np.diff(point) != 0)
    return np.column_stack([side[new], rim[point[new]]])


def _with_corners(
    vertices: FloatArray, triangles: IntArray, sides: IntArray, owners: IntArray, hanging: IntArray
) -> dict[int, list[int]]:
    """The rings of triangles that vertices hang on, with these among their corners."""
    on_side: dict[int, list[int]] = {}
    for side, vertex in hanging.tolist():
        on_side.setdefault(side, []).append(vertex)
    on_owner: dict[int, dict[tuple[int, int], list[int]]] = {}
    for side, corners in on_side.items():
        head, tail = sides[side].tolist()
        along = (vertices[corners] - vertices[head]) @ (vertices[tail] - vertices[head])
        in_order = [corners[k] for k in np.argsort(along, kind="stable").tolist()]
        on_owner.setdefault(int(owners[side]), {})[head, tail] = in_order
    rings = {}
    for owner, inserted in on_owner.items():
        a, b, c = triangles[owner].tolist()
        rings[owner] = [
            k for side in ((a, b), (b, c), (c, a)) for k in (side[0], *inserted.get(side, ()))
        ]
    return rings
