"""Which knots of a seed are bound in place or time: at visits of waypoints and meetings of pairs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.costs.formulation import TimedConstraints
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.interactions import Meeting
from stplan.scene.model import Agent, Visit
from stplan.seeding.rendezvous import Rendezvous

# A waypoint is the knot of the seed nearest to it, which must lie this close (m).
WAYPOINT_TOLERANCE = 1e-9
# Knots of a meeting are at the same time up to this (s).
SAME_TIME = 1e-9
# More than any distance of a scene, m.
FAR = 1e9


def find_timed_constraints(
    problem: PlanningProblem,
    layout: KnotLayout,
    knots: FloatArray,
    planned: Sequence[Rendezvous] = (),
) -> TimedConstraints:
    """The timed constraints of `problem` among `knots` (M, 3), where the curves nearly keep them.

    Pairs with a `planned` place meet there, others at the knots nearest in place and time.
    """
    places: list[int] = []
    stays: list[tuple[int, int]] = []
    dwell: list[float] = []
    windowed: list[tuple[int, tuple[float, float]]] = []
    for a, agent in enumerate(problem.scene.agents):
        if agent.path is not None:
            continue
        first = int(layout.first[a])
        visits = agent.visits or (Visit(),) * len(agent.waypoints)
        found = visit_knots(agent, knots[first : layout.last[a] + 1])
        for (arrive, leave), visit in zip(found, visits, strict=True):
            own = [first + arrive] if leave == arrive else [first + arrive, first + leave]
            places += own
            if len(own) == 2:
                stays.append((own[0], own[1]))
                dwell.append(visit.dwell)
            if visit.window is not None:
                windowed += [(knot, visit.window) for knot in own]
    links: list[tuple[int, int]] = []
    within: list[float] = []
    prescribed = problem.prescribed
    places_of = {place.agents: place for place in planned}
    for meeting in problem.meetings:
        if prescribed[meeting.first] and prescribed[meeting.second]:
            continue
        place = places_of.get((meeting.first, meeting.second))
        link = (
            _meeting_knots(problem, layout, knots, meeting)
            if place is None
            else _planned_knots(layout, knots, prescribed, place)
        )
        links.append(link)
        within.append(meeting.meet.within)
        if meeting.meet.window is not None:
            free = [knot for knot in link if not prescribed[layout.agent_of_knot[knot]]]
            windowed += [(knot, meeting.meet.window) for knot in free]
    return TimedConstraints(
        places=np.array(places, dtype=np.int64),
        stays=np.array(stays, dtype=np.int64).reshape(-1, 2),
        dwell=np.array(dwell, dtype=np.float64),
        windowed=np.array([knot for knot, _ in windowed], dtype=np.int64),
        window=np.array([window for _, window in windowed], dtype=np.float64).reshape(-1, 2),
        links=np.array(links, dtype=np.int64).reshape(-1, 2),
        within=np.array(within, dtype=np.float64),
    )


def visit_knots(agent: Agent, curve: FloatArray) -> list[tuple[int, int]]:
    """Knots of `curve` (n + 1, 3) at which each waypoint is reached and left, in order.

    They differ only where the agent dwells and has a knot for both.
    """
    found: list[tuple[int, int]] = []
    at = 0
    visits = agent.visits or (Visit(),) * len(agent.waypoints)
    for point, visit in zip(agent.waypoints, visits, strict=True):
        distance = np.hypot(*(curve[at:, :2] - point).T)
        close = np.flatnonzero(distance <= WAYPOINT_TOLERANCE)
        arrive = at + int(close[0] if len(close) else distance.argmin())
        leave = arrive
        if visit.dwell > 0 and len(close) > 1 and close[1] == close[0] + 1:
            leave = arrive + 1
        found.append((arrive, leave))
        at = leave
    return found


def _meeting_knots(
    problem: PlanningProblem,
    layout: KnotLayout,
    knots: FloatArray,
    meeting: Meeting,
) -> tuple[int, int]:
    """The nearest knots of two agents at a common time, or else the two nearest in time and place."""
    begins = layout.first[meeting.first], layout.first[meeting.second]
    own = knots[begins[0] : layout.last[meeting.first] + 1]
    other = knots[begins[1] : layout.last[meeting.second] + 1]
    step = own[:, None] - other[None]
    apart = np.hypot(step[:, :, 0], step[:, :, 1])
    late = np.abs(step[:, :, 2])
    if meeting.meet.window is not None:
        low, high = meeting.meet.window
        late = late + np.maximum(np.maximum(low - own[:, 2], own[:, 2] - high), 0.0)[:, None]
    # Those who meet already come first; nobody moves from a start, and nobody is drawn through a wall.
    order = np.hypot(apart, problem.time_scale * late)
    if problem.free_space is not None:
        heads, tails = (
            x.reshape(-1, 2) for x in np.broadcast_arrays(own[:, None, :2], other[None, :, :2])
        )
        hidden = problem.free_space.segment_clearance(heads, tails) <= 0
        order[hidden.reshape(order.shape)] += FAR
    order[0] += FAR
    order[:, 0] += FAR
    met = (late <= SAME_TIME) & (apart <= meeting.meet.within)
    order[met] = apart[met] - FAR
    i, j = np.unravel_index(int(order.argmin()), order.shape)
    return int(begins[0] + i), int(begins[1] + j)


def _planned_knots(
    layout: KnotLayout, knots: FloatArray, prescribed: BoolArray, place: Rendezvous
) -> tuple[int, int]:
    """The knots at a planned place: in space, or in time for an agent whose motion is prescribed."""
    found = []
    for agent, point in zip(place.agents, place.places, strict=True):
        own = knots[layout.first[agent] : layout.last[agent] + 1]
        off = (
            np.abs(own[:, 2] - place.time)
            if prescribed[agent]
            else np.hypot(*(own[:, :2] - point).T)
        )
        found.append(int(layout.first[agent]) + int(off.argmin()))
    return found[0], found[1]
