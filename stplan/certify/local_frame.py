"""Coordinates near the origin, and how far off a distance computed from them can be.

Coordinates far from the origin (eastings and northings) leave few digits for distances. The whole plan
and its walls are therefore moved by a multiple of a power of two, which changes no digit of any
coordinate. A plan that lies around the origin stays where it is.

With M the largest coordinate after the move and u = 2^-53 half a unit in the last place of 1, to first
order in u and each per coordinate unless it is a length:

- a position k_0 + f (k_1 - k_0) at an instant is off by 11 u M: f by 3 u relative to itself, the
  difference, the product and the sum by u each;
- the relative position of two agents at an end of a merged interval by 24 u M, so as a length by 34 u M;
- the point of the segment between two of them that is nearest to the origin lies off the best one by at
  most 23 u M in length (products and quotient that give the fraction of the way), and is itself evaluated
  to 14 u M;
- its length is off by 6 u M.

Together that is 77 u M. Between two segments in the plane (walls), the distance of an end to the other
segment is off by 49 u M: 37 u M by the cross product over the length, 12 u M where rounding takes the foot
for beyond an end. A crossing that rounding hides leaves an end within 45 u M of the other segment, so what
is found is off by 94 u M. `rounding` is the next power of two, 128 u M, for both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray

# Error of a computed distance over the largest coordinate: 128 * 2^-53.
ERROR_SHARE = 2.0**-46


@dataclass(frozen=True)
class LocalFrame:
    """Where the origin is put, and what distances are worth there.

    Attributes:
        origin: (2,) m, taken off every coordinate without rounding.
        rounding: a computed distance of two agents, or to a wall, is off by at most this, m.
    """

    origin: FloatArray
    rounding: float

    @staticmethod
    def around(*points: FloatArray) -> LocalFrame:
        """The frame for all `points` (N, 2), of which there is at least one, m."""
        low = np.min([own.min(axis=0) for own in points if len(own)], axis=0)
        high = np.max([own.max(axis=0) for own in points if len(own)], axis=0)
        largest = float(np.abs([low, high]).max())
        # At least the extent and the spacing of coordinates: multiples of it are taken off exactly.
        unit = max(2.0 ** np.ceil(np.log2(max(float((high - low).max()), 2.0**-500))),
                   float(np.spacing(largest)))  # fmt: skip
        origin = unit * np.trunc(0.5 * (low + high) / unit)
        reach = float(np.abs([low - origin, high - origin]).max())
        return LocalFrame(origin, ERROR_SHARE * reach)

    def local(self, points: FloatArray) -> FloatArray:
        """`points` (N, 2 or more) with their first two columns in this frame."""
        if not self.origin.any():
            return points
        moved = points.copy()
        moved[:, :2] -= self.origin
        return moved

    def outside(self, points: FloatArray) -> FloatArray:
        """`points` (N, 2) of this frame in coordinates of the scene, rounded."""
        return points + self.origin if self.origin.any() else points
