"""Distance of two straight segments in any number of dimensions, exactly, with where it is attained.

For segments p0 p1 and q0 q1 the squared distance |(p0 - q0) + s (p1 - p0) - t (q1 - q0)|^2 is a convex
quadratic in (s, t) on the unit square. Its minimiser is the free one clamped to the square, then
re-solved in the other parameter. Nothing is sampled, so nothing tunnels between samples.

Points are tuples of floats: their length is the dimension, known to the compiler.
"""

from __future__ import annotations

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inlined, inner

# A point in metres: (x, y) in the plane, (x, y, c t) in space-time.
Point = tuple[float, ...]

# Below this relative determinant two segments count as parallel: any common point of the overlap is
# closest, and the middle one keeps the answer symmetric.
PARALLEL = 1e-12
# Squared length below which a segment counts as a point (m^2).
POINT = 1e-24


@inlined
def clamp(value: float) -> float:
    """`value` moved into [0, 1]."""
    return min(max(value, 0.0), 1.0)


@inlined
def space_time_point(positions: FloatArray, index: int) -> Point:
    """Row `index` of positions (P, 3) in (x, y, c t)."""
    return positions[index, 0], positions[index, 1], positions[index, 2]


@inlined
def plane_point(points: FloatArray, index: int) -> Point:
    """Row `index` of points (n, 2), or of the plane part of positions (P, 3)."""
    return points[index, 0], points[index, 1]


@inner
def closest_parameters(p0: Point, p1: Point, q0: Point, q1: Point) -> tuple[float, float, float]:
    """Parameters (s, t) in [0, 1]^2 of the closest points, and the squared distance in m^2."""
    a = 0.0
    b = 0.0
    c = 0.0
    e = 0.0
    f = 0.0
    for x in range(len(p0)):
        u = p1[x] - p0[x]
        v = q1[x] - q0[x]
        r = p0[x] - q0[x]
        a += u * u
        b += u * v
        c += u * r
        e += v * v
        f += v * r
    s = 0.0
    t = 0.0
    if a <= POINT:
        if e > POINT:
            t = clamp(f / e)
    elif e <= POINT:
        s = clamp(-c / a)
    else:
        determinant = a * e - b * b
        if determinant > PARALLEL * a * e:
            s = clamp((b * f - c * e) / determinant)
        else:
            # Parallel: the middle of the overlap, in parameters of the first segment.
            low = -c / a
            high = (b - c) / a
            s = 0.5 * (clamp(min(low, high)) + clamp(max(low, high)))
        t = (b * s + f) / e
        if t < 0.0:
            t = 0.0
            s = clamp(-c / a)
        elif t > 1.0:
            t = 1.0
            s = clamp((b - c) / a)
    squared = 0.0
    for x in range(len(p0)):
        gap = (p0[x] - q0[x]) + s * (p1[x] - p0[x]) - t * (q1[x] - q0[x])
        squared += gap * gap
    return s, t, squared


@inlined
def squared_distance(p0: Point, p1: Point, q0: Point, q1: Point) -> float:
    """Squared distance of two segments in m^2."""
    return closest_parameters(p0, p1, q0, q1)[2]


@inlined
def closest_of_segments(
    positions: FloatArray, segments: IntArray, i: int, j: int
) -> tuple[float, float, float]:
    """`closest_parameters` of segments i and j of `segments` (S, 2) between `positions` (P, 3)."""
    return closest_parameters(
        space_time_point(positions, segments[i, 0]),
        space_time_point(positions, segments[i, 1]),
        space_time_point(positions, segments[j, 0]),
        space_time_point(positions, segments[j, 1]),
    )
