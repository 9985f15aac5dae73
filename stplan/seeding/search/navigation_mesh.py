"""A triangulated area and the shortest paths of points in it, exact whatever the triangles.

The search is Polyanya's (Cui, Harabor, Grastien, 2017): a node is a root point, from which a straight line
reaches an interval of a triangle's side; it is expanded across the triangle behind that side, and roots move
only to corners of the area. Nodes are settled in the order of a lower bound of the whole length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.growable import with_room
from stplan.seeding.search.heap import drop_root, push
from stplan.world.triangulation import triangles_of

# Shares of a side nearer than this to one of its ends are that end.
AT_END = 1e-13
# Lengths are ordered as whole numbers of so many parts of the mesh's extent.
PARTS = 1e12
# Roots whose distance differs by no more than this share are as good as each other.
SAME = 1e-12
# What stands for the corner of the start, and of the root before a corner that no path has reached.
AT_START, UNREACHED = -1, -2


class NavigationMesh(NamedTuple):
    """Triangles that cover an area.

    Attributes:
        corners: (V, 2) all on the boundary of the area, m.
        triangles: (F, 3) corners, anticlockwise.
        neighbours: (F, 3) the triangle beyond the side from corner k to k + 1, -1 where there is none.
        turning: (V,) corners at which shortest paths may turn: the area is reflex there.
    """

    corners: FloatArray
    triangles: IntArray
    neighbours: IntArray
    turning: BoolArray


def triangulated(area: shapely.Geometry) -> NavigationMesh:
    """The mesh of polygons, empty if they are."""
    rings = triangles_of(area)
    if not len(rings):
        nothing = np.empty((0, 3), dtype=np.int64)
        return NavigationMesh(np.empty((0, 2)), nothing, nothing, np.empty(0, dtype=bool))
    corners, place = np.unique(rings.reshape(-1, 2), axis=0, return_inverse=True)
    triangles = np.ravel(place).reshape(-1, 3).astype(np.int64)
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[twice < 0] = triangles[twice < 0][:, ::-1]
    triangles = np.ascontiguousarray(triangles[twice != 0])
    return NavigationMesh(corners, triangles, _neighbours(triangles), _turning(corners, triangles))


def _neighbours(triangles: IntArray) -> IntArray:
    """(F, 3) triangles that share the sides of `triangles`."""
    heads, tails = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    size = int(triangles.max(initial=0)) + 1
    side, reverse = heads * size + tails, tails * size + heads
    order = np.argsort(side, kind="stable")
    place = np.minimum(np.searchsorted(side[order], reverse), len(side) - 1)
    found = order[place]
    shared = side[found] == reverse
    return np.where(shared, found // 3, -1).reshape(-1, 3).astype(np.int64)


def _turning(corners: FloatArray, triangles: IntArray) -> BoolArray:
    """(V,) corners whose triangles take more than a straight angle."""
    total = np.zeros(len(corners))
    for k in range(3):
        at, to, fro = (corners[triangles[:, (k + j) % 3]] for j in range(3))
        u, v = to - at, fro - at
        cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        np.add.at(total, triangles[:, k], np.arctan2(cross, (u * v).sum(axis=1)))
    return np.asarray(total > np.pi)


class _Nodes(NamedTuple):
    """Nodes of the search: an interval of a side, seen from a root.

    Attributes:
        ends: (N, 4) left and right end of the interval as x, y, x, y.
        where: (N, 5) root, triangle behind the side, side in it, corner at the left end, at the right end
            (-1 where it is none).
    """

    ends: FloatArray
    where: IntArray


class _Roots(NamedTuple):
    """Points at which paths turn.

    Attributes:
        points: (R, 3) x, y, distance from the start.
        before: (R, 2) root before, and corner (AT_START: the start).
    """

    points: FloatArray
    before: IntArray


@kernel
def shortest_path(
    mesh: NavigationMesh, start: FloatArray, goal: FloatArray, first: int, last: int
) -> FloatArray:
    """Shortest polyline (n, 2) from `start` (2,) in triangle `first` to `goal` in `last`, empty if none."""
    corners, triangles = mesh.corners, mesh.triangles
    if first == last:
        direct = np.empty((2, 2))
        direct[0], direct[1] = start, goal
        return direct
    scale = _scale(corners)
    best, parent = np.full(len(corners), np.inf), np.full(len(corners), UNREACHED)
    nodes = _Nodes(np.empty((256, 4)), np.empty((256, 5), np.int64))
    roots = _Roots(np.empty((64, 3)), np.empty((64, 2), np.int64))
    heap = np.empty((256, 3), np.int64)
    roots.points[0, 0], roots.points[0, 1], roots.points[0, 2] = start[0], start[1], 0.0
    roots.before[0] = AT_START
    counts = np.array([0, 1, 0])
    found = np.empty((4, 8))
    made = 0
    for side in range(3):
        a, b = triangles[first, side], triangles[first, (side + 1) % 3]
        # Seen from inside, the side's first corner is on the right.
        made = _offer(found, made, side, corners[b], corners[a], b, a, -1)
    node, root, triangle = -1, 0, first
    while True:
        nodes = _Nodes(
            with_room(nodes.ends, counts[0] + made), with_room(nodes.where, counts[0] + made)
        )
        roots = _Roots(
            with_room(roots.points, counts[1] + 2), with_room(roots.before, counts[1] + 2)
        )
        heap = with_room(heap, counts[2] + made)
        _enter(
            found, made, root, triangle, mesh, goal, nodes, roots, heap, counts, best, parent, scale
        )
        while True:
            if counts[2] == 0:
                return np.empty((0, 2))
            node = heap[0, 1]
            drop_root(heap, counts[2])
            counts[2] -= 1
            root, triangle = nodes.where[node, 0], nodes.where[node, 1]
            corner = roots.before[root, 1]
            if corner < 0 or roots.points[root, 2] <= best[corner] * (1.0 + SAME):
                break
        if triangle == last:
            return _way(node, nodes, roots, goal)
        made = _expand(node, nodes, roots, mesh, found)


@inner
def _scale(corners: FloatArray) -> float:
    """By which lengths are multiplied to order them as whole numbers."""
    extent = 0.0
    for x in range(2):
        extent = max(extent, corners[:, x].max() - corners[:, x].min())
    return PARTS / max(extent, 1e-300)


@inlined
def _cross(ox: float, oy: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Twice the area of o, a, b: above 0 where b is left of the line from o to a."""
    return (ax - ox) * (by - oy) - (ay - oy) * (bx - ox)


@inner
def _offer(
    found: FloatArray, made: int, side: int, left: FloatArray, right: FloatArray,
    left_corner: int, right_corner: int, turn: int,
) -> int:  # fmt: skip
    """Note a successor behind a `side`; `turn` is the corner that becomes its root, -1 if none does."""
    if left[0] == right[0] and left[1] == right[1]:
        return made
    row = found[made]
    row[0], row[1], row[2], row[3] = left[0], left[1], right[0], right[1]
    row[4], row[5] = left_corner, right_corner
    row[6], row[7] = side, turn
    return made + 1


@inner
def _hit(
    root: FloatArray, through: FloatArray, head: FloatArray, tail: FloatArray, point: FloatArray
) -> int:
    """Where the ray from `root` `through` a point meets a side: 0 at its head, 1 at its tail, else -1."""
    dx, dy = through[0] - root[0], through[1] - root[1]
    ex, ey = tail[0] - head[0], tail[1] - head[1]
    across = dx * ey - dy * ex
    share = 0.0
    if across != 0.0:
        share = ((head[0] - root[0]) * dy - (head[1] - root[1]) * dx) / across
    if share <= AT_END:
        point[0], point[1] = head[0], head[1]
        return 0
    if share >= 1.0 - AT_END:
        point[0], point[1] = tail[0], tail[1]
        return 1
    point[0], point[1] = head[0] + share * ex, head[1] + share * ey
    return -1


@inner
def _expand(
    node: int, nodes: _Nodes, roots: _Roots, mesh: NavigationMesh, found: FloatArray
) -> int:
    """Successors of a node in `found` (4, 8); how many there are."""
    triangle, side = nodes.where[node, 1], nodes.where[node, 2]
    a = mesh.triangles[triangle, side]
    b = mesh.triangles[triangle, (side + 1) % 3]
    c = mesh.triangles[triangle, (side + 2) % 3]
    pa, pb, pc = mesh.corners[a], mesh.corners[b], mesh.corners[c]
    to_right, to_left = (side + 1) % 3, (side + 2) % 3
    root = roots.points[nodes.where[node, 0]]
    left, right = nodes.ends[node, :2], nodes.ends[node, 2:]
    left_corner, right_corner = nodes.where[node, 3], nodes.where[node, 4]
    at_left = root[0] == left[0] and root[1] == left[1]
    at_right = root[0] == right[0] and root[1] == right[1]
    beyond_left = not at_left and _cross(root[0], root[1], left[0], left[1], pc[0], pc[1]) > 0.0
    beyond_right = not at_right and _cross(root[0], root[1], right[0], right[1], pc[0], pc[1]) < 0.0
    one, other = np.empty(2), np.empty(2)
    made = 0
    if beyond_left:
        near = b if _hit(root, right, pb, pc, other) == 0 else -1
        if at_right:
            other[0], other[1], near = pb[0], pb[1], b
        end = _hit(root, left, pb, pc, one)
        far = b if end == 0 else (c if end == 1 else -1)
        made = _offer(found, made, to_right, one, other, far, near, -1)
        if left_corner == a and mesh.turning[a]:
            made = _offer(found, made, to_left, pa, pc, a, c, a)
            made = _offer(found, made, to_right, pc, one, c, far, a)
        return made
    if beyond_right:
        near = a if _hit(root, left, pa, pc, one) == 0 else -1
        if at_left:
            one[0], one[1], near = pa[0], pa[1], a
        end = _hit(root, right, pa, pc, other)
        far = a if end == 0 else (c if end == 1 else -1)
        made = _offer(found, made, to_left, one, other, near, far, -1)
        if right_corner == b and mesh.turning[b]:
            made = _offer(found, made, to_right, pc, pb, c, b, b)
            made = _offer(found, made, to_left, other, pc, far, c, b)
        return made
    end = 0 if at_left else _hit(root, left, pa, pc, one)
    if end >= 0:
        one[0], one[1] = (pa[0], pa[1]) if end == 0 else (pc[0], pc[1])
    near = a if end == 0 else (c if end == 1 else -1)
    made = _offer(found, made, to_left, one, pc, near, c, -1)
    end = 0 if at_right else _hit(root, right, pb, pc, other)
    if end >= 0:
        other[0], other[1] = (pb[0], pb[1]) if end == 0 else (pc[0], pc[1])
    far = b if end == 0 else (c if end == 1 else -1)
    return _offer(found, made, to_right, pc, other, c, far, -1)


@inner
def _enter(
    found: FloatArray, made: int, root: int, triangle: int, mesh: NavigationMesh, goal: FloatArray,
    nodes: _Nodes, roots: _Roots, heap: IntArray, counts: IntArray, best: FloatArray,
    parent: IntArray, scale: float,
) -> None:  # fmt: skip
    """Make nodes of the `found` successors that lead anywhere; counts of nodes, roots, heap entries."""
    corner, turned = -1, -1
    for k in range(made):
        row = found[k]
        side = int(row[6])
        behind = mesh.neighbours[triangle, side]
        if behind < 0:
            continue
        own = root
        if row[7] >= 0.0:
            # A node turns at no more than one corner.
            if corner < 0:
                corner = int(row[7])
                turned = _turn(corner, root, mesh, roots, counts, best, parent)
            own = turned
            if own < 0:
                continue
        node = counts[0]
        nodes.ends[node] = row[:4]
        entry = 0
        while mesh.neighbours[behind, entry] != triangle:
            entry += 1
        nodes.where[node, 0], nodes.where[node, 1], nodes.where[node, 2] = own, behind, entry
        nodes.where[node, 3], nodes.where[node, 4] = int(row[4]), int(row[5])
        length = roots.points[own, 2] + _bound(roots.points[own], row, goal)
        push(heap, counts[2], int(length * scale), node, 0)
        counts[0] += 1
        counts[2] += 1


@inner
def _turn(
    corner: int, root: int, mesh: NavigationMesh, roots: _Roots, counts: IntArray,
    best: FloatArray, parent: IntArray,
) -> int:  # fmt: skip
    """The root at the `corner` round which the path turns, -1 where another way there is no longer.

    Of ways of the same length one is enough: where one goes on along a shortest path, the other would make
    it as short, so that it goes on there, too. Among the blocks of a grid there would be more of them than
    can be counted. Nodes that share a root may turn at a corner each, around different triangles.
    """
    x, y = mesh.corners[corner, 0], mesh.corners[corner, 1]
    length = roots.points[root, 2] + np.hypot(x - roots.points[root, 0], y - roots.points[root, 1])
    before = roots.before[root, 1]
    if length < best[corner] * (1.0 - SAME):
        best[corner], parent[corner] = length, before
    elif parent[corner] != before or length > best[corner] * (1.0 + SAME):
        return -1
    number = counts[1]
    roots.points[number, 0], roots.points[number, 1], roots.points[number, 2] = x, y, length
    roots.before[number, 0], roots.before[number, 1] = root, corner
    counts[1] += 1
    return number


@inner
def _bound(root: FloatArray, row: FloatArray, goal: FloatArray) -> float:
    """Least length from `root` through the interval of `row` to the goal, were there no walls."""
    lx, ly, rx, ry = row[0], row[1], row[2], row[3]
    gx, gy = goal[0], goal[1]
    if _cross(lx, ly, rx, ry, gx, gy) < 0.0:
        # On this side of the interval: as long as to its mirror image.
        ex, ey = rx - lx, ry - ly
        share = 2.0 * ((gx - lx) * ex + (gy - ly) * ey) / (ex * ex + ey * ey)
        gx, gy = 2.0 * lx + share * ex - gx, 2.0 * ly + share * ey - gy
    if _cross(root[0], root[1], lx, ly, gx, gy) > 0.0:
        return np.hypot(lx - root[0], ly - root[1]) + np.hypot(gx - lx, gy - ly)
    if _cross(root[0], root[1], rx, ry, gx, gy) < 0.0:
        return np.hypot(rx - root[0], ry - root[1]) + np.hypot(gx - rx, gy - ry)
    return np.hypot(gx - root[0], gy - root[1])


@inner
def _way(node: int, nodes: _Nodes, roots: _Roots, goal: FloatArray) -> FloatArray:
    """The polyline of a node whose triangle holds the goal."""
    root = nodes.where[node, 0]
    count, own = 3, root
    while own >= 0:
        count, own = count + 1, roots.before[own, 0]
    way = np.empty((count, 2))
    way[count - 1] = goal
    place = count - 2
    x, y = roots.points[root, 0], roots.points[root, 1]
    lx, ly, rx, ry = nodes.ends[node]
    if _cross(x, y, lx, ly, goal[0], goal[1]) > 0.0:
        way[place, 0], way[place, 1] = lx, ly
        place -= 1
    elif _cross(x, y, rx, ry, goal[0], goal[1]) < 0.0:
        way[place, 0], way[place, 1] = rx, ry
        place -= 1
    while root >= 0:
        way[place] = roots.points[root, :2]
        place, root = place - 1, roots.before[root, 0]
    return way[place + 1 :].copy()
