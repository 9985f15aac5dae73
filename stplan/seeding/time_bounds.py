"""Proof that an agent's limits leave it too little time: no curve at all, clear or not, could hold them.

The ways between an agent's stops are at least as long as the shortest ones that keep (slightly less than)
its radius from the walls. At most `max_speed` it needs length over speed. At most `max_acceleration`,
from rest to rest in time T, no segment is faster than a T / 2, so its way is no longer than a T^2 / 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stplan.scene.model import Agent, Scene, Visit
from stplan.seeding.shortest_length import ShortestLengths

if TYPE_CHECKING:
    from stplan.world import FreeSpace

# Less than this share short of time is left to the search.
ROUNDING = 1e-9


def out_of_time(scene: Scene, free_space: FreeSpace | None) -> list[str]:
    """A sentence for every agent that provably cannot keep its limits and its times."""
    sentences = []
    lengths: dict[float, ShortestLengths] = {}
    for agent in scene.agents:
        if agent.path is not None or (agent.max_speed is None and agent.max_acceleration is None):
            continue
        stops = np.array([agent.start, *agent.waypoints, agent.goal])
        sentence = _late(agent, np.hypot(*np.diff(stops, axis=0).T).tolist())
        if not sentence and free_space is not None and agent.weights.wall > 0:
            if agent.radius not in lengths:
                lengths[agent.radius] = ShortestLengths(free_space, agent.radius)
            sentence = _late(agent, lengths[agent.radius].legs(stops))
        if sentence:
            sentences.append(sentence)
    return sentences


def _late(agent: Agent, legs: Sequence[float]) -> str:
    """What cannot be reached in time along ways of at least `legs` (m), or ""."""
    visits = (*(agent.visits or (Visit(),) * len(agent.waypoints)), Visit())
    speed = np.inf if agent.max_speed is None else agent.max_speed
    now, length = agent.start_time, 0.0
    for number, (leg, visit) in enumerate(zip(legs, visits, strict=True), start=1):
        now, length = now + leg / speed, length + leg
        begin, end = visit.window or (-np.inf, np.inf)
        now = max(now, begin) + visit.dwell
        last = min(end, agent.max_time)
        if now > last + ROUNDING * max(1.0, abs(last)):
            goal = number == len(legs)
            what = "reach its goal" if goal else f"have visited waypoint {number}"
            return (
                f"{agent.id} cannot {what} by {last:g} s: its way is at least {length:.4g} m long, "
                f"and at {speed:g} m/s that takes until {now:.4g} s"
            )
    limit, span = agent.max_acceleration, agent.max_time - agent.start_time
    if limit is not None and length > 0.5 * limit * span**2 * (1.0 + ROUNDING):
        return (
            f"{agent.id} cannot reach its goal by {agent.max_time:g} s: its way is at least "
            f"{length:.4g} m long, too long from rest to rest at {limit:g} m/s2"
        )
    return ""
