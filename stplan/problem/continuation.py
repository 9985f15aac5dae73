"""Curves up to a moment, and the scene of those who go on from there.

Whoever moves at that moment keeps its velocity until its next knot, so that its curve stays what it was up
to there: the past has no knots that were not planned, and changes of velocity take the time they were given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene, Visit, WorldChange
from stplan.scene.parts import part_of

# A waypoint was passed within this share of the agent's radius, as in the certificate.
PLACE_SHARE = 1e-6
# Knots this near to a moment, as a share of the curve's duration, are at it.
SAME_TIME = 1e-9

Curves = Mapping[str, FloatArray]


def curves_of(lines: WorldLines) -> dict[str, FloatArray]:
    """The curves by their agents' ids."""
    return dict(zip(lines.agent_ids, lines.curves(), strict=True))


def place_at(curve: FloatArray, time: float) -> FloatArray:
    """(3,) where a curve is at `time`, which becomes the time exactly; its ends beyond them."""
    x, y = (float(np.interp(time, curve[:, 2], curve[:, axis])) for axis in range(2))
    return np.array([x, y, time])


def piece_of(curve: FloatArray, begin: float, end: float) -> FloatArray:
    """The piece (n, 3) of a curve between two times within its own, the later first."""
    inner = curve[(curve[:, 2] > begin) & (curve[:, 2] < end)]
    return np.vstack([place_at(curve, begin), inner, place_at(curve, end)])


def continued_scene(earlier: Scene, curves: Curves, change: WorldChange) -> Scene:
    """The scene from `change` on, of those who are there: each goes on from where its curve is.

    Args:
        earlier: the world before.
        curves: whole curves (n, 3) of those who were planned before, by id.
    """
    before = {agent.id: agent for agent in earlier.agents}
    delays = dict(change.delays)
    kept, agents = [], []
    for a, agent in enumerate(change.scene.agents):
        if agent.id in change.removed:
            continue
        curve = curves.get(agent.id)
        if curve is None or curve[0, 2] >= change.at:
            own: Agent | None = agent
        else:
            own = _going_on(agent, before.get(agent.id), curve, change.at, delays.get(agent.id))
        if own is not None:
            kept.append(a)
            agents.append(own)
    part = part_of(change.scene, kept, agents)
    # What is wrong with it stands in no file.
    return replace(part, agent_paths=tuple(agent.id for agent in agents), locations={})


def _going_on(
    agent: Agent, before: Agent | None, curve: FloatArray, at: float, delay: float | None
) -> Agent | None:
    """An agent from the moment `at` on; None where it is gone by then."""
    if agent.path is not None:
        path = np.array(agent.path)
        if path[-1, 2] <= at:
            return None if agent.after_arrival == "vanish" else _standing(agent, path, at)
        rest = np.vstack([place_at(path, at), path[path[:, 2] > at]])
        x, y, t = rest[0].tolist()
        return replace(agent, path=tuple(map(tuple, rest.tolist())), start=(x, y), start_time=t)
    arrived = bool(curve[-1, 2] <= at)
    if arrived and agent.after_arrival == "vanish":
        return None
    same = before is not None and (before.goal, before.goal_places) == (
        agent.goal,
        agent.goal_places,
    )
    if arrived:
        standing = _standing(agent, curve, at)
        return (
            standing if same else replace(standing, goal=agent.goal, goal_places=agent.goal_places)
        )
    x, y, _ = place_at(curve, at).tolist()
    segment = int(np.searchsorted(curve[:, 2], at, side="left")) - 1
    step = curve[segment + 1] - curve[segment]
    left = float(curve[segment + 1, 2]) - at
    velocity = (float(step[0] / step[2]), float(step[1] / step[2]))
    if left <= SAME_TIME * float(curve[-1, 2] - curve[0, 2]):
        left = 0.0
    if delay is not None:
        velocity, left = (0.0, 0.0), delay
    points, visits = _ahead(agent, curve, at)
    return replace(
        agent,
        start=(x, y),
        start_time=at,
        start_velocity=velocity,
        start_duration=left,
        waypoints=points,
        visits=visits,
    )


def _standing(agent: Agent, curve: FloatArray, at: float) -> Agent:
    """An agent that arrived before, on its goal."""
    x, y = curve[-1, :2].tolist()
    return replace(
        agent, start=(x, y), goal=(x, y), start_time=at, goal_places=(), waypoints=(), visits=(), path=None,
        start_velocity=None, start_duration=0.0,
    )  # fmt: skip


def _ahead(
    agent: Agent, curve: FloatArray, at: float
) -> tuple[tuple[tuple[float, float], ...], tuple[Visit, ...]]:
    """The waypoints not visited before `at`; of the one being visited, what is left of its dwell."""
    visits = agent.visits or (Visit(),) * len(agent.waypoints)
    past = np.vstack([curve[curve[:, 2] < at], place_at(curve, at)])
    knot = 0
    for number, (point, visit) in enumerate(zip(agent.waypoints, visits, strict=True)):
        there = np.hypot(*(past[knot:, :2] - point).T) <= PLACE_SHARE * agent.radius
        if not there.any():
            return agent.waypoints[number:], agent.visits[number:]
        knot += int(there.argmax())
        stays = int(np.argmin(there[int(there.argmax()) :])) if not there[-1] else 0
        since = at - float(past[knot, 2])
        if there[-1] and not stays and since < visit.dwell:
            rest = replace(visit, dwell=visit.dwell - since)
            return agent.waypoints[number:], (rest, *agent.visits[number + 1 :])
    return (), ()


def joined_history(past: Curves, curves: Curves, at: float) -> dict[str, FloatArray]:
    """Whole curves: what was executed before `at`, and what is planned from then on.

    Those who go on as they did have no knot at that moment; those who are not planned any more end there.
    """
    joined: dict[str, FloatArray] = {}
    for name, curve in past.items():
        new = curves.get(name)
        before = curve[curve[:, 2] < at]
        if new is None:
            ended = bool(curve[-1, 2] <= at)
            joined[name] = curve if ended else np.vstack([before, place_at(curve, at)])
        elif not len(before):
            joined[name] = new
        elif curve[-1, 2] <= at and _stands(new):
            joined[name] = curve
        else:
            joined[name] = np.vstack([before, new[_goes_on(curve, new, at) :]])
    return joined | {name: curve for name, curve in curves.items() if name not in past}


def _stands(curve: FloatArray) -> bool:
    return bool((curve[:, :2] == curve[0, :2]).all())


def _goes_on(curve: FloatArray, new: FloatArray, at: float) -> int:
    """1 where `new` begins with the rest of a segment of `curve`, and ends it on its very knot."""
    later = curve[curve[:, 2] > at]
    same = len(later) and len(new) > 1 and bool((new[1] == later[0]).all())
    return int(same)
