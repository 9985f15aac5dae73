"""What became of a scene that was played: who was caught, stayed near, came near, or got to its goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from stplan.amounts import amount
from stplan.arrays import FloatArray
from stplan.problem.continuation import curves_of
from stplan.problem.ends import last_moment
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene
from stplan.scene.moving_goals import REPLAN_EVERY
from stplan.wording import count


@dataclass(frozen=True)
class Capture:
    """Who was caught, by whom, and when (s)."""

    prey: str
    pursuer: str
    time: float

    @property
    def sentence(self) -> str:
        """In words."""
        return f"{self.pursuer} catches {self.prey} at {amount(self.time)} s"


@dataclass(frozen=True)
class Escort:
    """How well an agent follows another.

    Attributes:
        since: when it is near enough first, s; None where it never is.
        share: of the time from then on in which it is near enough.
        furthest: from then on, m between centres.
    """

    follower: str
    leader: str
    within: float
    since: float | None
    share: float
    furthest: float

    @property
    def sentence(self) -> str:
        """In words."""
        if self.since is None:
            return f"{self.follower} never comes within {amount(self.within)} m of {self.leader}"
        return (
            f"{self.follower} is within {amount(self.within)} m of {self.leader} first at "
            f"{amount(self.since)} s, and for {amount(100.0 * self.share)} % of the time from then on; "
            f"at most {amount(self.furthest)} m away"
        )


@dataclass(frozen=True)
class Evasion:
    """How an agent that evades fared: who came nearest, how near (m between centres), and when (s)."""

    prey: str
    pursuer: str
    distance: float
    time: float
    caught: bool

    @property
    def sentence(self) -> str:
        """In words."""
        ended = "is caught" if self.caught else "is never caught"
        return (
            f"{self.prey} {ended}; {self.pursuer} comes within {amount(self.distance)} m of it, "
            f"at {amount(self.time)} s"
        )


@dataclass(frozen=True)
class GoalReached:
    """When an agent whose goal is a point is there for good, s."""

    agent: str
    time: float


@dataclass(frozen=True)
class Chases:
    """What became of a scene that was played."""

    replan_every: float
    captures: tuple[Capture, ...]
    escorts: tuple[Escort, ...]
    evasions: tuple[Evasion, ...]
    arrivals: tuple[GoalReached, ...]

    @property
    def sentences(self) -> list[str]:
        """In words, captures in the order of time."""
        kinds: tuple[Sequence[Capture | Escort | Evasion], ...] = (
            self.captures,
            self.escorts,
            self.evasions,
        )
        sentences = [one.sentence for kind in kinds for one in kind]
        if self.arrivals:
            times = [one.time for one in self.arrivals]
            mean = amount(sum(times) / len(times))
            last = max(self.arrivals, key=lambda one: one.time)
            sentences.append(
                f"{count(len(times), 'agent')} with a point as goal: there at {mean} s on average, "
                f"{last.agent} last, at {amount(last.time)} s"
            )
        return sentences

    def as_dict(self) -> dict[str, Any]:
        """For report.json."""
        return asdict(self)


def chases(scene: Scene, lines: WorldLines) -> Chases:
    """What became of the goals that move of `scene` as `lines` (in any order) were executed."""
    curves = curves_of(lines)
    end = last_moment(lines)
    agents = {agent.id: agent for agent in scene.agents}
    caught, escorts, evasions, arrivals = [], [], [], []
    for agent in scene.agents:
        curve = curves[agent.id]
        goal = agent.moving_goal
        if curve[-1, 2] < end:
            hunters = [
                (_gaps(curve, curves[one.id])[1][-1], one.id) for one in _pursuers(agents, agent.id)
            ]
            if hunters:
                caught.append(Capture(agent.id, min(hunters)[1], float(curve[-1, 2])))
        if goal is None and curve[-1, 2] >= end:
            away = np.flatnonzero((curve[:, :2] != curve[-1, :2]).any(axis=1))
            there = int(away[-1]) + 1 if len(away) else 0
            arrivals.append(GoalReached(agent.id, float(curve[there, 2])))
        if goal is not None and goal.kind == "follow":
            escorts.append(_escort(agent, curve, goal.others[0], curves[goal.others[0]]))
        if goal is not None and goal.kind == "evade":
            evasions.append(_evasion(agent, curves, end))
    caught.sort(key=lambda one: (one.time, one.prey))
    every = scene.replan_every or REPLAN_EVERY
    return Chases(every, tuple(caught), tuple(escorts), tuple(evasions), tuple(arrivals))


def _pursuers(agents: dict[str, Agent], prey: str) -> list[Agent]:
    return [
        one
        for one in agents.values()
        if one.moving_goal is not None
        and one.moving_goal.kind == "pursue"
        and prey in one.moving_goal.others
    ]


def _gaps(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n,) knots of either curve while both are there, s, and how far apart the centres are then, m."""
    times = np.union1d(one[:, 2], other[:, 2])
    first, last = max(one[0, 2], other[0, 2]), min(one[-1, 2], other[-1, 2])
    times = times[(times >= first) & (times <= last)]
    offsets = [
        np.interp(times, one[:, 2], one[:, x]) - np.interp(times, other[:, 2], other[:, x])
        for x in range(2)
    ]
    return times, np.hypot(*offsets)


def _escort(agent: Agent, curve: FloatArray, leader: str, other: FloatArray) -> Escort:
    """How well an agent follows, between knots by the distances at them."""
    within = agent.moving_goal.within if agent.moving_goal is not None else 0.0
    times, distance = _gaps(curve, other)
    near = distance <= within
    if not near.any():
        return Escort(agent.id, leader, within, None, 0.0, float(distance.max()))
    k = int(near.argmax())
    return Escort(
        agent.id, leader, within, float(times[k]), float(near[k:].mean()), float(distance[k:].max())
    )


def _evasion(agent: Agent, curves: dict[str, FloatArray], end: float) -> Evasion:
    """How near whoever is evaded came, at knots."""
    curve = curves[agent.id]
    found = []
    for name in agent.moving_goal.others if agent.moving_goal is not None else ():
        times, distance = _gaps(curve, curves[name])
        k = int(distance.argmin())
        found.append((float(distance[k]), name, float(times[k])))
    least, name, time = min(found)
    return Evasion(agent.id, name, least, time, bool(curve[-1, 2] < end))
