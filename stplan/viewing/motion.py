"""Where agents are and how fast, at any times."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.world_lines import WorldLines


def positions(lines: WorldLines, leaves: FloatArray, times: FloatArray) -> FloatArray:
    """(A, T, 2) places in m at `times` (T,) s; NaN where an agent is not there.

    Args:
        leaves: (A,) until when each agent is present; it stands still after its last knot.
    """
    places = np.empty((lines.num_agents, len(times), 2))
    for a, curve in enumerate(lines.curves()):
        for axis in range(2):
            places[a, :, axis] = np.interp(times, curve[:, 2], curve[:, axis])
        places[a, (times < curve[0, 2]) | (times > leaves[a])] = np.nan
    return places


def segment_speeds(curve: FloatArray) -> FloatArray:
    """(n,) speed in m/s on each segment of a curve (n + 1, 3)."""
    step = np.diff(curve, axis=0)
    speeds: FloatArray = np.hypot(step[:, 0], step[:, 1]) / step[:, 2]
    return speeds


def nice_step(span: float, most: int) -> float:
    """The smallest of 1, 2, 5 times a power of ten that divides `span` into at most `most` parts."""
    if span <= 0:
        return 1.0
    rough = span / most
    power = 10.0 ** np.floor(np.log10(rough))
    return float(
        next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough * 0.999)
    )
