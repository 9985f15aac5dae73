"""Rings of points as files write them. Lengths in m."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import Point
from stplan.schema.mapping import Fault


def rectangle_ring(values: Sequence[float], path: str, faults: list[Fault]) -> tuple[Point, ...]:
    """The corners of [xmin, ymin, xmax, ymax], counterclockwise."""
    x0, y0, x1, y1 = values
    for axis, low, high in (("x", x0, x1), ("y", y0, y1)):
        if low >= high:
            faults.append(
                (
                    path,
                    f"reaches from {axis}min {low:g} to {axis}max {high:g}; "
                    f"[xmin, ymin, xmax, ymax] with {axis}min < {axis}max is expected",
                )
            )
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def simple_ring(
    points: Sequence[Sequence[float]], path: str, faults: list[Fault]
) -> tuple[Point, ...]:
    """The corners, once each: a ring may be written closed."""
    import shapely

    ring = tuple((point[0], point[1]) for point in points)
    if ring[0] == ring[-1]:
        ring = ring[:-1]
    if len(set(ring)) < 3:
        faults.append(
            (path, f"has {len(set(ring))} distinct points; a ring of at least 3 is expected")
        )
        return ring
    shape = shapely.Polygon(np.array(ring))
    if not shape.is_valid:
        reason = shapely.is_valid_reason(shape)
        faults.append((path, f"crosses or touches itself ({reason}); a simple ring is expected"))
    elif shape.area == 0:
        faults.append((path, "has no area; corners that are not on one line are expected"))
    return ring


def polyline(
    points: Sequence[Sequence[float]], path: str, faults: list[Fault]
) -> tuple[Point, ...]:
    """The points of a line, those left out that repeat the one before."""
    line = [(point[0], point[1]) for point in points]
    kept = tuple(point for k, point in enumerate(line) if k == 0 or point != line[k - 1])
    if len(kept) < 2:
        faults.append((path, "is a single point; a line through at least 2 is expected"))
    return kept
