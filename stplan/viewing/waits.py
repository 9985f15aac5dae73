"""Who waits, when, and for whom: what a reader of a plan asks first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.viewing.motion import positions, segment_speeds
from stplan.viewing.run_view import RunView

# An agent waits while slower than this share of its own mean speed, for at least this share of its way.
_SLOW = 0.5
_LONG = 0.03


@dataclass(frozen=True)
class Wait:
    """Agent `a` goes slowly from `begin` to `end` s; `b` is nearest to it meanwhile, None if nobody."""

    a: int
    begin: float
    end: float
    b: int | None


def waits(view: RunView) -> list[Wait]:
    """All waits, agent by agent in the order of time."""
    found = []
    for a, curve in enumerate(view.lines.curves()):
        duration = curve[-1, 2] - curve[0, 2]
        length = np.hypot(*np.diff(curve[:, :2], axis=0).T).sum()
        slow = segment_speeds(curve) < _SLOW * length / duration
        edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(int)))
        for first, last in edges.reshape(-1, 2).tolist():
            begin, end = float(curve[first, 2]), float(curve[last, 2])
            if end - begin >= _LONG * duration:
                found.append(Wait(a, begin, end, _nearest(view, a, np.linspace(begin, end, 20))))
    return found


def _nearest(view: RunView, a: int, times: FloatArray) -> int | None:
    """Who of those that keep their distance from `a` comes nearest at `times`."""
    places = positions(view.lines, view.leaves, times)
    offset = places - places[a]
    gap = np.hypot(offset[..., 0], offset[..., 1]) - view.distance[a][:, None]
    gap[np.isnan(gap) | ~view.collides[a][:, None]] = np.inf
    least = gap.min(axis=1)
    best = int(least.argmin())
    return best if np.isfinite(least[best]) else None
