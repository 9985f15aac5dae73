"""Points of arrays as kernels take them, and the distance of two segments."""

from __future__ import annotations

from stplan.arrays import FloatArray
from stplan.compiled import kernel
from stplan.geometry.segments import Point, closest_parameters


@kernel
def closest(p0: Point, p1: Point, q0: Point, q1: Point) -> tuple[float, float, float]:
    """`closest_parameters`, compiled."""
    return closest_parameters(p0, p1, q0, q1)


def as_points(*rows: FloatArray) -> tuple[Point, ...]:
    """Rows (d,) as tuples of floats."""
    return tuple(tuple(row.tolist()) for row in rows)


def apart_squared(p0: FloatArray, p1: FloatArray, q0: FloatArray, q1: FloatArray) -> float:
    """Squared distance of the segments p0 p1 and q0 q1, rows (d,) in m."""
    return closest(*as_points(p0, p1, q0, q1))[2]
