"""Proof that an agent's limits leave it too little time: no curve at all, clear or not, could hold them.

The ways between an agent's stops are at least as long as the shortest ones that keep (slightly less than)
its radius from the walls. At most `max_speed` it needs length over speed. At most `max_acceleration`,
from speed v to rest in time T, no segment is faster than (v + a T) / 2, so its way is no longer than that for
a time T.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.reasons import Reason
from stplan.scene.model import Agent, Visit

if TYPE_CHECKING:
    import shapely

    from stplan.world import FreeSpace

# Erosion uses slightly less than the radius, and arcs are cut short: ways come out too short, never too long.
EROSION = 1.0 - 1e-3
ARC_SEGMENTS = 3
# Free spaces with more corners than this are taken for open.
MOST_CORNERS = 250
# Less than this share short of time is left to the search.
ROUNDING = 1e-9


def out_of_time(problem: PlanningProblem) -> tuple[Reason, ...]:
    """A reason for every agent that provably cannot keep its limits and its times."""
    reasons = []
    areas: dict[float, tuple[shapely.Geometry, FloatArray]] = {}
    for agent in problem.scene.agents:
        if agent.path is not None or (agent.max_speed is None and agent.max_acceleration is None):
            continue
        stops = np.array([agent.start, *agent.waypoints, agent.goal])
        legs = np.hypot(*np.diff(stops, axis=0).T)
        reason = _late(agent, legs)
        if reason is None and problem.free_space is not None and agent.weights.wall > 0:
            if agent.radius not in areas:
                areas[agent.radius] = _corners(problem.free_space, agent.radius)
            reason = _late(agent, _shortest(*areas[agent.radius], stops, legs))
        if reason is not None:
            reasons.append(reason)
    return tuple(reasons)


def _late(agent: Agent, legs: FloatArray) -> Reason | None:
    """What cannot be reached in time along ways of at least `legs` (m), if anything."""
    visits = (*(agent.visits or (Visit(),) * len(agent.waypoints)), Visit())
    speed = np.inf if agent.max_speed is None else agent.max_speed
    now, length = agent.start_time, 0.0
    for number, (leg, visit) in enumerate(zip(legs.tolist(), visits, strict=True), start=1):
        now, length = now + leg / speed, length + leg
        begin, end = visit.window or (-np.inf, np.inf)
        now = max(now, begin) + visit.dwell
        last = min(end, agent.max_time)
        if now > last + ROUNDING * max(1.0, abs(last)):
            figures = {"latest": last, "earliest": now, "length": length}
            if agent.max_speed is not None:
                figures["speed"] = agent.max_speed
            if number < len(legs):
                figures["waypoint"] = number
            return Reason("limits of time", (agent.id,), proven=True, figures=figures)
    limit, span = agent.max_acceleration, agent.max_time - agent.start_time
    first = 0.0 if agent.start_velocity is None else float(np.hypot(*agent.start_velocity))
    if limit is not None and length > 0.5 * (first + limit * span) * span * (1.0 + ROUNDING):
        figures = {"latest": agent.max_time, "length": length, "acceleration": limit}
        return Reason("limit of acceleration", (agent.id,), proven=True, figures=figures)
    return None


def _corners(free_space: FreeSpace, radius: float) -> tuple[shapely.Geometry, FloatArray]:
    """Where an agent's centre may be, a little more, and the corners (C, 2) that ways bend around."""
    import shapely
    from shapely.geometry.polygon import orient

    area = free_space.polygon.buffer(-EROSION * radius, quad_segs=ARC_SEGMENTS)
    corners = []
    for part in shapely.get_parts(area):
        # Free space lies left of every ring of an oriented polygon; ways bend where it turns away.
        oriented = orient(part)
        for ring in (oriented.exterior, *oriented.interiors):
            points = np.asarray(ring.coords)[:-1]
            ahead, behind = (
                np.roll(points, -1, axis=0) - points,
                points - np.roll(points, 1, axis=0),
            )
            turn = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
            corners.append(points[turn < 0])
    found = np.vstack(corners) if corners else np.empty((0, 2))
    return area.buffer(1e-6 * radius), found


def _shortest(
    area: shapely.Geometry, corners: FloatArray, stops: FloatArray, straight: FloatArray
) -> FloatArray:
    """Lengths of the shortest ways between consecutive `stops`, `straight` where unknown."""
    if len(corners) > MOST_CORNERS or not len(corners):
        return straight
    import shapely
    from scipy.sparse.csgraph import dijkstra

    shapely.prepare(area)
    nodes = np.vstack([stops, corners])
    i, j = np.triu_indices(len(nodes), 1)
    lines = shapely.linestrings(np.stack([nodes[i], nodes[j]], axis=1))
    sees = shapely.covers(area, lines)
    lengths = np.zeros((len(nodes), len(nodes)))
    # Nodes that coincide still need an entry: a length of 0 means that there is no edge.
    lengths[i[sees], j[sees]] = np.maximum(np.hypot(*(nodes[i] - nodes[j])[sees].T), 1e-12)
    reached = dijkstra(lengths, directed=False, indices=np.arange(len(stops)))
    found = reached[np.arange(len(stops) - 1), np.arange(1, len(stops))]
    return np.where(np.isfinite(found), np.maximum(found, straight), straight)
