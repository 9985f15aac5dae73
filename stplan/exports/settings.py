"""What is common to all formats that a run is written in."""

from __future__ import annotations

from dataclasses import dataclass

import shapely

from stplan.exports.frames import Frames, frames_of
from stplan.viewing.run_view import RunView

STEP = 0.1
SMOOTHING = 0.5


@dataclass(frozen=True)
class ExportSettings:
    """How a run is written.

    Attributes:
        step: s between samples.
        smoothing: s over which headings follow motion.
        pace: height of a second in rods, m; None is the scene's time scale.
    """

    step: float = STEP
    smoothing: float = SMOOTHING
    pace: float | None = None

    def frames(self, view: RunView) -> Frames:
        """The run at fixed steps."""
        return frames_of(view, self.step, self.smoothing)

    @staticmethod
    def geometry(view: RunView) -> str:
        """The map as well-known text; empty where there is none."""
        if view.free_space is None:
            return ""
        return shapely.to_wkt(view.free_space.polygon, rounding_precision=9)
