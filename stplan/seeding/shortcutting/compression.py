"""Compression: clear curves played faster or slower as a whole, so that agents are as fast as they may be.

One factor for all times keeps who passes whom. Slower is always clear; faster brings rods nearer, by little
where c is large beside the speeds, so that is proven, and less of it done where it is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify

# Limits of speed are kept with this share to spare.
SPARE = 0.97
# How much of the compression is tried, most first.
SHARES = (1.0, 0.75, 0.5, 0.25)


def compressed(problem: PlanningProblem, curves: Sequence[FloatArray]) -> list[FloatArray]:
    """Clear `curves` with all times scaled so that the fastest agent is nearly as fast as it may be.

    As they are where agents start at different times, or where times are given; and where accelerations are
    limited: these are reached from curves that are slow.
    """
    current = list(curves)
    pace = _pace(problem, current)
    if pace <= 0.0 or not _free_times(problem):
        return current
    begin = float(problem.start_times[0])
    latest = max(float(curve[-1, 2]) for curve in current)
    most = (float(problem.max_times.min()) - begin) / (latest - begin)
    factor = min(pace / SPARE, most)
    for share in SHARES if factor < 1.0 else (1.0,):
        scale = 1.0 + share * (factor - 1.0)
        scaled = [
            np.column_stack([curve[:, :2], begin + scale * (curve[:, 2] - begin)])
            for curve in current
        ]
        if scale >= 1.0 or not verify(problem, scaled):
            return scaled
    return current


def _pace(problem: PlanningProblem, curves: Sequence[FloatArray]) -> float:
    """The greatest speed over its limit, of all that have one."""
    greatest = 0.0
    for agent, curve in zip(problem.scene.agents, curves, strict=True):
        if agent.path is None and agent.max_speed is not None:
            step = np.diff(curve, axis=0)
            speed = float((np.hypot(step[:, 0], step[:, 1]) / step[:, 2]).max())
            greatest = max(greatest, speed / agent.max_speed)
    return greatest


def _free_times(problem: PlanningProblem) -> bool:
    """Whether all start together, stop at once, and nothing has a time of its own."""
    together = bool((problem.start_times == problem.start_times[0]).all())
    timed = any(
        agent.path is not None
        or agent.visits
        or agent.max_acceleration is not None
        or agent.start_velocity is not None
        for agent in problem.scene.agents
    )
    return together and not timed and not problem.meetings


def arriving_as(problem: PlanningProblem, curves: Sequence[FloatArray]) -> PlanningProblem:
    """The problem of agents that like to arrive when `curves` do: nothing is slowed down beyond that."""
    arrivals = np.array([curve[-1, 2] for curve in curves])
    return replace(problem, preferred_times=arrivals)
