"""Random curves and problems, a room, and distances the slow way."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.world import FreeSpace
from tests.geometry.points import apart_squared
from tests.seeding.families import agent, scene


def random_curve(rng: np.random.Generator, count: int, extent: float = 10.0) -> FloatArray:
    """A curve with uneven times from 0 to 20 s."""
    times = np.sort(rng.uniform(0.0, 20.0, count))
    times[0], times[-1] = 0.0, 20.0
    return np.column_stack([rng.uniform(0.0, extent, (count, 2)), times])


def random_problem(
    rng: np.random.Generator, count: int, **changes: object
) -> tuple[PlanningProblem, list[FloatArray]]:
    """A problem of `count` agents with unequal radii, and curves that fit its ends."""
    curves = [random_curve(rng, int(rng.integers(2, 8))) for _ in range(count)]
    agents = [
        agent(
            f"a{k}",
            curve[0, :2],
            curve[-1, :2],
            radius=float(rng.uniform(0.1, 0.4)),
            **changes,
        )
        for k, curve in enumerate(curves)
    ]
    return PlanningProblem.from_scene(scene(agents, horizon=25.0, time_scale=0.7), None), curves


def room(*holes: shapely.Polygon) -> FreeSpace:
    """A square room of side 10 m with obstacles."""
    return FreeSpace.from_polygon(
        shapely.box(0, 0, 10, 10).difference(shapely.unary_union(list(holes)))
    )


def brute_distance(first: FloatArray, second: FloatArray) -> float:
    """Over all pairs of segments."""
    return min(
        float(np.sqrt(apart_squared(first[i], first[i + 1], second[j], second[j + 1])))
        for i in range(len(first) - 1)
        for j in range(len(second) - 1)
    )
