"""When agents are there: from their start until they arrive, or, where they stay, until the end of all."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.scene.model import Scene


def present_until(scene: Scene, arrivals: FloatArray) -> FloatArray:
    """(A,) until when every agent of `scene` is there, s, given when each arrives (A,)."""
    stays = np.array([agent.after_arrival == "stay" for agent in scene.agents], dtype=bool)
    return np.where(stays, scene.final_time, arrivals)
