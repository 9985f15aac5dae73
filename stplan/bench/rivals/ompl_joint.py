"""OMPL's RRT-Connect in the joint space of all agents; everyone waits for the slowest on every piece."""

from __future__ import annotations

from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.bench.rivals.task import Motion, Task, no_motion

PACKAGE = "ompl"
NAME = "OMPL, joint RRT-Connect"

# Of the extent of the space: how finely straight pieces are checked.
RESOLUTION = 0.002
SIMPLIFY = 5.0
ROOM = 3.0


def drive(task: Task) -> Motion:
    """A joint path within `time_limit` seconds, walked as fast as the speed allows."""
    from ompl import base, geometric, util

    util.RNG.setSeed(1)
    util.setLogLevel(util.LogLevel.LOG_NONE)
    count = len(task.radii)
    space = base.RealVectorStateSpace(2 * count)
    places = np.vstack([task.starts, task.goals])
    bounds = base.RealVectorBounds(2 * count)
    for axis in range(2 * count):
        bounds.setLow(axis, float(places[:, axis % 2].min() - ROOM))
        bounds.setHigh(axis, float(places[:, axis % 2].max() + ROOM))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: _valid(task, _places(state, count)))
    setup.getSpaceInformation().setStateValidityCheckingResolution(RESOLUTION)
    ends = []
    for values in (task.starts, task.goals):
        state = space.allocState()
        for axis, value in enumerate(values.ravel()):
            state[axis] = float(value)
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    setup.solve(task.time_limit)
    if not setup.haveExactSolutionPath():
        return no_motion(count, f"no path within {task.time_limit:.0f} s")
    setup.simplifySolution(SIMPLIFY)
    states = setup.getSolutionPath().getStates()
    return _timed(np.array([_places(state, count) for state in states]), task.speed)


def _places(state: Any, count: int) -> FloatArray:
    return np.array([state[axis] for axis in range(2 * count)]).reshape(count, 2)


def _valid(task: Task, places: FloatArray) -> bool:
    first, second = np.triu_indices(len(places), 1)
    apart = np.hypot(*(places[first] - places[second]).T)
    if (apart <= task.radii[first] + task.radii[second]).any():
        return False
    return task.free_space is None or bool((task.free_space.clearance(places) > task.radii).all())


def _timed(stops: FloatArray, speed: float) -> Motion:
    """Stops (n, A, 2) with times such that nobody is faster than `speed`."""
    longest = np.linalg.norm(np.diff(stops, axis=0), axis=2).max(axis=1)
    keep = np.append(True, longest > 0)
    times = np.append(0.0, np.cumsum(longest[longest > 0] / speed))
    curves = [np.column_stack([stops[keep, agent], times]) for agent in range(stops.shape[1])]
    return Motion(curves, np.ones(len(curves), dtype=bool))
