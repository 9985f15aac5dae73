"""When agents are there: from their start until they arrive, or, where they stay, until the end of all."""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray


def present_until(stays: BoolArray, arrivals: FloatArray, final_time: float) -> FloatArray:
    """(A,) until when every agent is there, s.

    Args:
        stays: (A,) whether it stands on its goal after it has arrived.
        arrivals: (A,) when it arrives, s.
        final_time: until when staying agents stand there, s.
    """
    return np.where(stays, final_time, arrivals)
