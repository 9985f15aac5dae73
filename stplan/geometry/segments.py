"""Distance of two straight segments in three dimensions, exactly, with where it is attained.

For segments p0 p1 and q0 q1 the squared distance |(p0 - q0) + s (p1 - p0) - t (q1 - q0)|^2 is a convex
quadratic in (s, t) on the unit square. Its minimiser is the free one clamped to the square, then
re-solved in the other parameter. Nothing is sampled, so nothing tunnels between samples.
"""

from __future__ import annotations

from stplan.compiled import inlined, kernel

# Below this relative determinant two segments count as parallel: any common point of the overlap is
# closest, and the middle one keeps the answer symmetric.
PARALLEL = 1e-12
# Squared length below which a segment counts as a point (m^2).
POINT = 1e-24


@inlined
def clamp(value: float) -> float:
    """`value` moved into [0, 1]."""
    return min(max(value, 0.0), 1.0)


@kernel
def closest_parameters(
    p0x: float, p0y: float, p0z: float, p1x: float, p1y: float, p1z: float,
    q0x: float, q0y: float, q0z: float, q1x: float, q1y: float, q1z: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Parameters (s, t) in [0, 1]^2 of the closest points, and the squared distance in m^2."""
    ux, uy, uz = p1x - p0x, p1y - p0y, p1z - p0z
    vx, vy, vz = q1x - q0x, q1y - q0y, q1z - q0z
    rx, ry, rz = p0x - q0x, p0y - q0y, p0z - q0z
    a = ux * ux + uy * uy + uz * uz
    e = vx * vx + vy * vy + vz * vz
    c = ux * rx + uy * ry + uz * rz
    f = vx * rx + vy * ry + vz * rz
    s = 0.0
    t = 0.0
    if a <= POINT:
        if e > POINT:
            t = clamp(f / e)
    elif e <= POINT:
        s = clamp(-c / a)
    else:
        b = ux * vx + uy * vy + uz * vz
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
    dx = rx + s * ux - t * vx
    dy = ry + s * uy - t * vy
    dz = rz + s * uz - t * vz
    return s, t, dx * dx + dy * dy + dz * dz


@kernel
def squared_distance(
    p0x: float, p0y: float, p0z: float, p1x: float, p1y: float, p1z: float,
    q0x: float, q0y: float, q0z: float, q1x: float, q1y: float, q1z: float,
) -> float:  # fmt: skip
    """Squared distance of two segments in m^2."""
    return closest_parameters(p0x, p0y, p0z, p1x, p1y, p1z, q0x, q0y, q0z, q1x, q1y, q1z)[2]
