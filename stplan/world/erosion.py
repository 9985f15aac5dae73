"""Polygons eroded by a radius, without the noise of floating-point flags."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray


def eroded(polygon: shapely.Geometry, radius: float, **options: Any) -> shapely.Geometry:
    """`polygon` less everything within `radius` (m) of its boundary; `options` are shapely's buffer's.

    The offset curves of GEOS intersect lines that may be parallel and discard what comes of it. The
    division leaves its mark in the processor's status word, which numpy reads after the call and
    reports as a warning although nothing is wrong with the result. What is wrong with a result would
    be coordinates that are not finite, and those are refused.

    Raises:
        ArithmeticError: the result has coordinates that are not finite.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        shape = shapely.buffer(polygon, -radius, **options)
        bounds = np.asarray(shapely.bounds(shape))
    if not shape.is_empty and not np.isfinite(bounds).all():
        raise ArithmeticError(f"the area {radius:g} m off the walls cannot be computed")
    return shape


def nearest_in(area: shapely.Geometry, point: FloatArray) -> FloatArray:
    """The point (2,) of an area that is nearest to `point` (2,)."""
    line = shapely.shortest_line(area, shapely.Point(point))
    return np.asarray(shapely.get_coordinates(line)[0])
