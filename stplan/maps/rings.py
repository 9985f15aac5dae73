"""Rings of points as files write them. Lengths in m."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np

from stplan.amounts import distinct
from stplan.arrays import Point
from stplan.schema.mapping import GIVEN, Fault, FileModel, key
from stplan.schema.quantities import NotNegative


def rectangle_ring(values: Sequence[float], path: str, faults: list[Fault]) -> tuple[Point, ...]:
    """The corners of [xmin, ymin, xmax, ymax], counterclockwise."""
    x0, y0, x1, y1 = values
    for axis, low, high in (("x", x0, x1), ("y", y0, y1)):
        if low >= high:
            first, last = distinct(low, high)
            faults.append(
                (
                    path,
                    f"reaches from {axis}min {first} to {axis}max {last}; "
                    f"[xmin, ymin, xmax, ymax] with {axis}min < {axis}max is expected",
                )
            )
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


class RepairKeys(FileModel):
    """What happens to rings that are not simple."""

    repair: Annotated[bool | None, GIVEN] = key(
        "mend rings that cross, touch or retrace themselves, with a warning; false refuses them",
        True,
    )


class WeldKeys(FileModel):
    """What happens to cracks of what was meant to be joined."""

    weld: Annotated[NotNegative | None, GIVEN] = key(
        "m; of `mesh`: cracks up to this wide are closed, default: far below the smallest radius and the "
        "extent; of `file`: gaps between ends of walls drawn as lines are, default: 0"
    )


def read_ring(
    points: Sequence[Sequence[float]], path: str, faults: list[Fault], *, repair: bool = False
) -> tuple[Point, ...]:
    """The corners, once each: a ring may be written closed, in either direction.

    Args:
        repair: whether one that is not simple is no fault: it is mended later on.
    """
    import shapely

    ring = tuple((point[0], point[1]) for point in points)
    if ring[0] == ring[-1]:
        ring = ring[:-1]
    if len(set(ring)) < 3:
        faults.append(
            (path, f"has {len(set(ring))} distinct points; a ring of at least 3 is expected")
        )
        return ring
    corners = np.array(ring)
    if shapely.get_dimensions(shapely.convex_hull(shapely.multipoints(corners))) < 2:
        faults.append((path, "has no area; corners that are not on one line are expected"))
    elif not repair and not shapely.is_valid(shapely.Polygon(corners)):
        from stplan.maps.repair import enclosed, even_odd

        what = "; ".join(enclosed(corners, even_odd).faults)
        faults.append((path, f"{what}; a simple ring is expected, or map.repair: true"))
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
