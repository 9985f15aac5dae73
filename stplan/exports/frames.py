"""A run at fixed steps in time: where everybody is, and where everybody looks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.analysis.paths import positions
from stplan.arrays import FloatArray
from stplan.errors import UsageError
from stplan.viewing.run_view import RunView

# Nobody turns for a displacement smaller than this, m.
STILL = 1e-3
MOST_FRAMES = 20_000_000


@dataclass(frozen=True)
class Frames:
    """A run sampled.

    Attributes:
        step: s between frames.
        times: (T,) s, from the run's begin; the last is the run's end or less than a step after.
        places: (A, T, 2) m, NaN where an agent is not there.
        headings: (A, T) rad, counterclockwise from the x axis, continuous in time.
    """

    step: float
    times: FloatArray
    places: FloatArray
    headings: FloatArray

    def rows(self, agent: int) -> list[int]:
        """The frames in which an agent is there."""
        return np.flatnonzero(~np.isnan(self.places[agent, :, 0])).tolist()


def frames_of(view: RunView, step: float, smoothing: float) -> Frames:
    """Sample a run.

    A heading is the direction from where the agent is half of `smoothing` (s) earlier to where it is half of
    it later. Who does not move keeps the last heading, and before the first motion has that one.

    Raises:
        UsageError: there would be too many frames.
    """
    count = int(np.ceil((view.end - view.begin) / step - 1e-9)) + 1
    if count * view.num_agents > MOST_FRAMES:
        raise UsageError(
            f"{count} steps of {view.num_agents} agents are too many; a longer step is expected"
        )
    times: FloatArray = np.asarray(view.begin + np.arange(count) * step, dtype=np.float64)
    # Whoever is there at the end of the run is so in the last frame, which may be a little later.
    leaves = np.where(view.leaves >= view.end, np.inf, view.leaves)
    places = positions(view.lines, leaves, times)
    headings = np.stack([_headings(curve, times, smoothing) for curve in view.lines.curves()])
    return Frames(step, times, places, headings)


def _headings(curve: FloatArray, times: FloatArray, smoothing: float) -> FloatArray:
    half = max(smoothing, 1e-6) / 2
    ends = [
        np.stack([np.interp(times + shift, curve[:, 2], curve[:, axis]) for axis in (0, 1)])
        for shift in (-half, half)
    ]
    step = ends[1] - ends[0]
    moving = np.flatnonzero(np.hypot(*step) > min(STILL, STILL * smoothing))
    if not len(moving):
        whole = curve[-1, :2] - curve[0, :2]
        return np.full(len(times), np.arctan2(whole[1], whole[0]))
    angles = np.unwrap(np.arctan2(step[1, moving], step[0, moving]))
    last = np.searchsorted(moving, np.arange(len(times)), side="right") - 1
    return np.asarray(angles[np.maximum(last, 0)])
