"""Whether plane segments touch or cross, exactly up to the rounding of the triangles' orientations."""

from __future__ import annotations

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.geometry.allocation import new_flags
from stplan.geometry.segments import Point, plane_point


@inlined
def segments_cross(a: Point, b: Point, p: Point, q: Point) -> bool:
    """Whether the plane segments a b and p q have a point in common; points are (x, y) in m."""
    if max(a[0], b[0]) < min(p[0], q[0]) or min(a[0], b[0]) > max(p[0], q[0]):
        return False
    if max(a[1], b[1]) < min(p[1], q[1]) or min(a[1], b[1]) > max(p[1], q[1]):
        return False
    # On which side of one segment's line each end of the other lies, and the other way round.
    side_p = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    side_q = (b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0])
    side_a = (q[0] - p[0]) * (a[1] - p[1]) - (q[1] - p[1]) * (a[0] - p[0])
    side_b = (q[0] - p[0]) * (b[1] - p[1]) - (q[1] - p[1]) * (b[0] - p[0])
    return side_p * side_q <= 0.0 and side_a * side_b <= 0.0


@kernel
def crossings(
    starts: FloatArray, ends: FloatArray, pairs: IntArray, edges: FloatArray
) -> BoolArray:
    """Which of the pairs (N, 2) of segment and edge touch or cross, (N,).

    Args:
        starts, ends: (S, 2) of the segments, m.
        edges: (E, 4) as x0, y0, x1, y1, m.
    """
    result = new_flags(len(pairs))
    for k in range(len(pairs)):
        i = pairs[k, 0]
        e = pairs[k, 1]
        result[k] = segments_cross(
            plane_point(starts, i), plane_point(ends, i),
            (edges[e, 0], edges[e, 1]), (edges[e, 2], edges[e, 3]),
        )  # fmt: skip
    return result
