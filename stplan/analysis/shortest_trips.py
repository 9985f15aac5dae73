"""How far and how long agents travel at least, each as if nobody else were there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray, Point
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.shortest_ways import shortest_lengths
from stplan.scene.model import Agent, Visit


def shortest_legs(problem: PlanningProblem) -> list[FloatArray]:
    """Lower bounds (w + 1,) of the ways between an agent's consecutive stops, m, wherever it may end.

    An agent whose motion is prescribed has none.
    """
    points = {a: one.points for one in problem.scene.assignments for a in one.members}
    return [
        lengths if agent.path is not None else _open_ended(agent, lengths, points.get(a, ()))
        for a, (agent, lengths) in enumerate(
            zip(problem.scene.agents, shortest_lengths(problem), strict=True)
        )
    ]


def shortest_duration(agent: Agent, legs: FloatArray) -> float:
    """What `agent` needs at least from its start to its arrival, s, on ways of at least `legs` (w + 1,) m.

    Its limits of motion, windows and dwells are kept.
    """
    speed = np.inf if agent.max_speed is None else agent.max_speed
    now = agent.start_time
    visits = agent.visits or (Visit(),) * len(agent.waypoints)
    for leg, visit in zip(legs.tolist(), (*visits, Visit()), strict=True):
        begin = -np.inf if visit.window is None else visit.window[0]
        now = max(now + leg / speed, begin) + visit.dwell
    needed = now - agent.start_time
    if agent.max_acceleration is not None:
        # From speed v to rest no way is longer than (v + a T) T / 2.
        limit, length = agent.max_acceleration, float(legs.sum())
        if agent.start_velocity is None:
            return max(needed, float(np.sqrt(2.0 * length / limit)))
        first = float(np.hypot(*agent.start_velocity))
        root = float(np.sqrt(first**2 + 8.0 * limit * length))
        needed = max(needed, 0.5 * (root - first) / limit)
    return needed


def _open_ended(agent: Agent, legs: FloatArray, points: Sequence[Point]) -> FloatArray:
    """Lengths of ways between stops (m), of which the last leads straight to the nearest possible end.

    Ends may be anywhere in the agent's places, or on one of the `points` that are assigned.
    """
    if not agent.goal_places and not points:
        return legs
    import shapely

    origin = shapely.points([agent.start, *agent.waypoints][-1])
    ends = [place.shape() for place in agent.goal_places] or list(shapely.points(np.array(points)))
    return np.append(legs[:-1], min(legs[-1], float(shapely.distance(ends, origin).min())))
