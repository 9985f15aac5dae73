"""Shortest ways around the walls, one an agent, walked at constant speed.

Nobody heeds anybody else here: these curves start the relaxation where straight lines would cross
walls, and everything else that agents do is measured against them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.search.shortest_ways import Way, shortest_ways


def geodesic_curves(
    problem: PlanningProblem, ways: Sequence[Way | None] | None = None
) -> list[FloatArray | None]:
    """One (n, 3) curve an agent from its start time to the time it would like to arrive.

    None where an agent's stops are not connected at its radius. Prescribed paths are
    kept; agents that ignore walls, and all in the open plane, go straight. `ways` are the shortest
    ones, found here where they are not given.
    """
    ways = shortest_ways(problem) if ways is None else ways
    curves: list[FloatArray | None] = []
    for agent, (given, stops, way) in enumerate(
        zip(problem.paths, problem.stops, ways, strict=True)
    ):
        walled = problem.free_space is not None and problem.heeds_walls[agent]
        if given is not None or (walled and way is None):
            curves.append(given)
            continue
        points = stops if way is None else way.points
        curves.append(
            _walked(
                points, float(problem.start_times[agent]), float(problem.preferred_times[agent])
            )
        )
    return curves


def _walked(way: FloatArray, begin: float, end: float) -> FloatArray:
    """`way` (n, 2) at constant speed from `begin` to `end` (s); knots that coincide are dropped."""
    steps = np.hypot(*np.diff(way, axis=0).T)
    if steps.sum() <= 0.0:
        return np.column_stack([way[[0, -1]], [begin, end]])
    kept = np.concatenate([[True], steps > 0.0])
    way = way[kept]
    along = np.concatenate([[0.0], np.cumsum(steps[steps > 0.0])])
    times = begin + (end - begin) * along / along[-1]
    times[-1] = end
    return np.ascontiguousarray(np.column_stack([way, times]))
