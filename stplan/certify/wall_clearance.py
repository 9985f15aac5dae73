"""Distance of whole paths to the boundary of the free space, in closed form, and whether they stay inside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from stplan.arrays import FloatArray, IntArray
from stplan.certify.box_tree import LEAF, BoxTree, box_distance
from stplan.certify.local_frame import LocalFrame
from stplan.compiled import inner, kernel
from stplan.world import FreeSpace

# Boxes count as further away than what was found only when they are so by more than rounding.
_SURE = 1.0 - 1e-14


@dataclass(frozen=True)
class WallDistances:
    """How near every path comes to the walls.

    Attributes:
        distance: (A,) m, negative where the path leaves the free space, by as much as its furthest knot
            lies outside (or minus zero's neighbour where only a segment does).
        place: (A, 2) where on the path, m.
    """

    distance: FloatArray
    place: FloatArray


def wall_distances(
    free_space: FreeSpace, curves: Sequence[FloatArray], frame: LocalFrame | None = None
) -> WallDistances:
    """Distances of `curves`, each (n + 1, 2 or more), to the boundary.

    Args:
        frame: of curves and boundary, made where it is not given; its `rounding` bounds the error.
    """
    walls = free_space.boundary_segments
    if frame is None:
        frame = LocalFrame.around(*(curve[:, :2] for curve in curves), free_space.boundary_vertices)
    edges = np.ascontiguousarray(frame.local(walls.reshape(-1, 2)).reshape(-1, 4))
    tree = BoxTree.over(edges)
    distance, place = _distances(edges, tree, [frame.local(curve[:, :2]) for curve in curves])
    place = frame.outside(place)
    # A path that keeps away from the boundary lies where its start lies.
    inside = free_space.contains(np.array([curve[0, :2] for curve in curves]))
    for a in np.flatnonzero(~inside | (distance <= frame.rounding)).tolist():
        points = curves[a][:, :2]
        outside = np.flatnonzero(~free_space.contains(points))
        local = frame.local(points[outside])
        depth, _ = _distances(edges, tree, [np.vstack([point, point]) for point in local])
        if depth.max(initial=0.0) > 0.0:
            worst = int(depth.argmax())
            distance[a], place[a] = -depth[worst], points[outside[worst]]
        elif not shapely.covers(free_space.polygon, _path(points)):
            distance[a] = -float(np.finfo(float).tiny)
    return WallDistances(distance, place)


def _distances(
    edges: FloatArray, tree: BoxTree, paths: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """(P,) least distances of `paths` to `edges` and (P, 2) where on the path, all in one frame."""
    distance, place = np.full(len(paths), np.inf), np.empty((len(paths), 2))
    if len(paths):
        offsets = np.concatenate([[0], np.cumsum([len(path) for path in paths])])
        knots = np.ascontiguousarray(np.vstack(paths))
        _nearest(knots, offsets.astype(np.int64), edges, tree.boxes, tree.order, distance, place)
    return distance, place


def _path(points: FloatArray) -> shapely.Geometry:
    """The path in the plane: a line, or a point for an agent that never moves."""
    moves = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
    points = points[moves]
    return shapely.Point(points[0]) if len(points) == 1 else shapely.LineString(points)


def time_at(curve: FloatArray, place: FloatArray) -> float:
    """When a path passes nearest to `place` (x, y), s."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    squared = (step[:, :2] ** 2).sum(axis=1)
    along = ((place - start[:, :2]) * step[:, :2]).sum(axis=1) / np.where(squared > 0, squared, 1)
    along = np.clip(along, 0.0, 1.0)
    gap = np.hypot(*(start[:, :2] + along[:, None] * step[:, :2] - place).T)
    best = int(gap.argmin())
    return float(start[best, 2] + along[best] * step[best, 2])


@kernel
def _nearest(
    knots: FloatArray,
    offsets: IntArray,
    edges: FloatArray,
    boxes: FloatArray,
    order: IntArray,
    distance: FloatArray,
    place: FloatArray,
) -> None:
    """Least distance of every path; of equal ones that of the first edge, then of the first segment."""
    leaves = len(boxes) // 2
    stack = np.empty(64, dtype=np.int64)
    for a in range(len(distance)):
        best = np.inf
        edge = -1
        segment = -1
        for s in range(offsets[a], offsets[a + 1] - 1):
            ax, ay, bx, by = knots[s, 0], knots[s, 1], knots[s + 1, 0], knots[s + 1, 1]
            low_x, low_y, high_x, high_y = min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)
            stack[0] = 1
            depth = 1
            while depth:
                depth -= 1
                node = stack[depth]
                if box_distance(boxes[node], low_x, low_y, high_x, high_y) * _SURE > best:
                    continue
                if node < leaves:
                    near = box_distance(boxes[2 * node], low_x, low_y, high_x, high_y)
                    far = box_distance(boxes[2 * node + 1], low_x, low_y, high_x, high_y)
                    swap = far < near
                    stack[depth] = 2 * node if swap else 2 * node + 1
                    stack[depth + 1] = 2 * node + 1 if swap else 2 * node
                    depth += 2
                    continue
                first = LEAF * (node - leaves)
                for e in order[first : min(first + LEAF, len(order))]:
                    gap = segment_distance(
                        ax, ay, bx, by, edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
                    )
                    # Segments come in order: only edges can come before the one found.
                    if gap < best or (gap == best and e < edge):
                        best, edge, segment = gap, e, s
        distance[a] = best
        place[a, 0], place[a, 1] = _closest(knots[segment], knots[segment + 1], edges[edge])


@inner
def segment_distance(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> float:
    """Distance of the segments from a to b and from c to d, m."""
    apart = (
        max(ax, bx) < min(cx, dx)
        or max(cx, dx) < min(ax, bx)
        or max(ay, by) < min(cy, dy)
        or max(cy, dy) < min(ay, by)
    )
    if not apart:
        cross = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
        if cross != 0.0:
            along = ((ay - cy) * (dx - cx) - (ax - cx) * (dy - cy)) / cross
            other = ((ay - cy) * (bx - ax) - (ax - cx) * (by - ay)) / cross
            if 0.0 <= along <= 1.0 and 0.0 <= other <= 1.0:
                return 0.0
    return min(
        point_distance(ax, ay, cx, cy, dx, dy),
        point_distance(bx, by, cx, cy, dx, dy),
        point_distance(cx, cy, ax, ay, bx, by),
        point_distance(dx, dy, ax, ay, bx, by),
    )


@inner
def point_distance(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Distance of a point to the segment from a to b, m."""
    ux, uy = bx - ax, by - ay
    squared = ux * ux + uy * uy
    if squared == 0.0:
        return np.sqrt((x - ax) * (x - ax) + (y - ay) * (y - ay))
    along = ((x - ax) * ux + (y - ay) * uy) / squared
    if along <= 0.0:
        return np.sqrt((x - ax) * (x - ax) + (y - ay) * (y - ay))
    if along >= 1.0:
        return np.sqrt((x - bx) * (x - bx) + (y - by) * (y - by))
    across = ((ay - y) * ux - (ax - x) * uy) / squared
    return abs(across) * np.sqrt(squared)


@inner
def _closest(a: FloatArray, b: FloatArray, edge: FloatArray) -> tuple[float, float]:
    """The point of the segment from a to b that is nearest to an edge, or where they cross."""
    if segment_distance(a[0], a[1], b[0], b[1], edge[0], edge[1], edge[2], edge[3]) == 0.0:
        ux, uy = edge[2] - edge[0], edge[3] - edge[1]
        cross = (b[0] - a[0]) * uy - (b[1] - a[1]) * ux
        if cross != 0.0:
            along = ((a[1] - edge[1]) * ux - (a[0] - edge[0]) * uy) / cross
            along = min(max(along, 0.0), 1.0)
            return a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1])
    best = np.inf
    x, y = a[0], a[1]
    for end in range(2):
        wall_x, wall_y = edge[2 * end], edge[2 * end + 1]
        own_x, own_y = _foot(wall_x, wall_y, a[0], a[1], b[0], b[1])
        gap = np.sqrt((own_x - wall_x) ** 2 + (own_y - wall_y) ** 2)
        if gap < best:
            best, x, y = gap, own_x, own_y
    for end in range(2):
        own_x, own_y = (a[0], a[1]) if end == 0 else (b[0], b[1])
        wall_x, wall_y = _foot(own_x, own_y, edge[0], edge[1], edge[2], edge[3])
        gap = np.sqrt((own_x - wall_x) ** 2 + (own_y - wall_y) ** 2)
        if gap < best:
            best, x, y = gap, own_x, own_y
    return x, y


@inner
def _foot(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> tuple[float, float]:
    """The point of the segment from a to b that is nearest to (x, y)."""
    ux, uy = bx - ax, by - ay
    squared = ux * ux + uy * uy
    along = 0.0
    if squared > 0.0:
        along = ((x - ax) * ux + (y - ay) * uy) / squared
    if along <= 0.0:
        return ax, ay
    if along >= 1.0:
        return bx, by
    return ax + along * ux, ay + along * uy
