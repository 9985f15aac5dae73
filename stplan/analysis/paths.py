"""Lengths, speeds and places of single curves (n + 1, 3) as x, y [m], t [s]."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.world_lines import WorldLines


def segment_lengths(curve: FloatArray) -> FloatArray:
    """(n,) length of every segment in the plane, m."""
    step = np.diff(curve[:, :2], axis=0)
    lengths: FloatArray = np.hypot(step[:, 0], step[:, 1])
    return lengths


def path_length(curve: FloatArray) -> float:
    """Length in the plane, m."""
    return float(segment_lengths(curve).sum())


def segment_speeds(curve: FloatArray) -> FloatArray:
    """(n,) speed on every segment, m/s."""
    speeds: FloatArray = segment_lengths(curve) / np.diff(curve[:, 2])
    return speeds


def place_at(curve: FloatArray, time: float) -> tuple[float, float]:
    """Where an agent is at `time` (s); before its first and after its last knot it stands there."""
    x, y = (float(np.interp(time, curve[:, 2], curve[:, axis])) for axis in (0, 1))
    return x, y


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
