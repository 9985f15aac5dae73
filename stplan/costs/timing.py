"""Penalties of times that are not as they should be: what leads a seed to visits and meetings on time.

For knots i, j with low <= t_j - t_i <= high asked for (i = -1 stands for time 0), the cost is
weight / 2 times the square of what is missing, in s. It is convex and has curvature only where
something is missing.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.term import Term

NONE = -1


class Timing(Term):
    """Half the squared seconds by which differences of times miss their intervals.

    Args:
        knots: (N, 2) i and j, i = `NONE` for the time of j itself.
        low, high: (N,) s, the interval asked for.
        weight: per s^2.
        num_knots: M.
    """

    name = "timing"

    def __init__(
        self, knots: IntArray, low: FloatArray, high: FloatArray, weight: float, num_knots: int
    ) -> None:
        self._first, self._second = knots[:, 0], knots[:, 1]
        self._absolute = self._first == NONE
        self._low, self._high = low, high
        self._weight = weight
        self._num_knots = num_knots

    def missing(self, knots: FloatArray) -> FloatArray:
        """(N,) signed seconds outside the interval: positive too late, negative too early."""
        earlier = np.where(self._absolute, 0.0, knots[self._first, 2])
        difference = knots[self._second, 2] - earlier
        return np.maximum(difference - self._high, 0.0) - np.maximum(self._low - difference, 0.0)

    def value(self, knots: FloatArray) -> float:
        """The cost."""
        return float(0.5 * self._weight * (self.missing(knots) ** 2).sum())

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3); only times matter."""
        slope = self._weight * self.missing(knots)
        result = np.zeros((self._num_knots, 3))
        np.add.at(result[:, 2], self._second, slope)
        np.add.at(result[:, 2], self._first, np.where(self._absolute, 0.0, -slope))
        return result

    def hessian_structure(self) -> tuple[IntArray, IntArray]:
        """(t_j, t_j), then (t_i, t_i) and the mixed entry of relative ones."""
        pair = ~self._absolute
        low = np.minimum(self._first, self._second)[pair]
        high = np.maximum(self._first, self._second)[pair]
        rows = np.concatenate([self._second, self._first[pair], high])
        columns = np.concatenate([self._second, self._first[pair], low])
        return 3 * rows + 2, 3 * columns + 2

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of the structure."""
        stiff = np.where(self.missing(knots) != 0.0, self._weight, 0.0)
        pair = stiff[~self._absolute]
        return np.concatenate([stiff, pair, -pair])
