"""The axes of space-time: places first, time last, whatever the number of dimensions of space.

Curves are in (x, y, t) with t in s; rods are in (x, y, c t), all in m, where distances make sense.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray

# The column of time in an array of knots or positions, and those of the place.
TIME = -1
PLACE = slice(None, -1)


def in_metres(curve: FloatArray, time_scale: float) -> FloatArray:
    """A curve (..., d) in (x, y, t) as positions in (x, y, c t), m; `time_scale` is c in m/s."""
    positions = np.array(curve, dtype=np.float64)
    positions[..., TIME] *= time_scale
    return positions


def in_seconds(positions: FloatArray, time_scale: float) -> FloatArray:
    """Positions (..., d) in (x, y, c t) as a curve in (x, y, t)."""
    curve = np.array(positions, dtype=np.float64)
    curve[..., TIME] /= time_scale
    return curve
