"""Curves -> polylines that the true curve never leaves by more than a tolerance."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.arrays import FloatArray


def thick(line: FloatArray, tolerance: float) -> shapely.Geometry:
    """The area around a chord polyline (n, 2) that holds every curve within `tolerance` of it.

    A wall that bends is replaced by this, so that chords never give away floor.
    """
    return shapely.buffer(
        shapely.linestrings(line), tolerance, cap_style="square", join_style="mitre"
    )


def bezier(points: FloatArray, tolerance: float, most: int = 256) -> FloatArray:
    """(n, 2) places on a Bezier curve of the given control points (3 or 4, 2), ends included.

    Chords are within `tolerance` of the curve, by the bound on its second derivative.
    """
    degree = len(points) - 1
    bend = np.abs(np.diff(points, n=2, axis=0)).max() * np.sqrt(2) * degree * (degree - 1)
    count = int(np.clip(np.ceil(np.sqrt(bend / (8 * max(tolerance, 1e-12)))), 1, most))
    t = np.linspace(0.0, 1.0, count + 1)[:, None]
    places = np.broadcast_to(points, (count + 1, *points.shape))
    while places.shape[1] > 1:
        places = (1 - t[:, None]) * places[:, :-1] + t[:, None] * places[:, 1:]
    return places[:, 0]
