"""Who waits, where, for how long, and for whom.

An agent waits, or holds back, where it is slower than on average over its way. Whom it waits for is found by
letting it go on instead, along its own way at its mean pace: the agent it would be the first to
meet is the one it waits for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.certify.pair_clearance import nearest_moments
from stplan.explain.explanation import Section, at, count, metres
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import Interactions, scene_interactions
from stplan.scene.model import Scene

# Slower than this share of its mean pace an agent holds back, where somebody is in its way.
SLOW = 0.8
# Slower than this share it waits, whoever is in its way.
VERY_SLOW = 0.5
# A wait costs at least this share of the whole travelling time; shorter ones are passed over.
LEAST_LOSS = 0.02


@dataclass(frozen=True)
class Meeting:
    """Whom an agent would have met: how much too near (m), when (s) and where (m)."""

    agent: str
    overlap: float
    time: float
    place: tuple[float, float]


@dataclass(frozen=True)
class Wait:
    """An agent that is slow for a while.

    Attributes:
        begin, end: from when to when, s.
        lost: how much sooner it had got as far at its mean pace, s.
        speed, pace: while it waits and on average, m/s.
        place: where it is in the middle of it, m.
        meeting: what it avoids; None where nobody is in its way.
    """

    agent: str
    begin: float
    end: float
    lost: float
    speed: float
    pace: float
    place: tuple[float, float]
    meeting: Meeting | None

    @property
    def is_wait(self) -> bool:
        """Whether it is slow enough to be called a wait by itself."""
        return self.speed < VERY_SLOW * self.pace

    def sentence(self) -> str:
        """In words."""
        still = self.speed < 0.02 * self.pace
        how = "stands still" if still else f"goes at {self.speed:.2g} m/s"
        when = f"from t = {self.begin:.2f} to {self.end:.2f} s near {at(self.place)}"
        cost = f"which costs it {self.lost:.2f} s at its mean pace of {self.pace:.2g} m/s"
        if self.meeting is None:
            return f"{self.agent} {how} {when}, {cost}; nobody is in its way then, it has time"
        met = self.meeting
        verb = "waits" if self.is_wait else "holds back"
        spot = f"at t = {met.time:.2f} s, {at(met.place)}"
        return (
            f"{self.agent} {verb} for {met.agent}: it {how} {when}, {cost}; going on, it would "
            f"have been {metres(met.overlap)} too near {spot}"
        )


def waits(scene: Scene, lines: WorldLines) -> list[Wait]:
    """Every wait of every agent that plans its way; `lines` in scene order. The longest come first."""
    interactions = scene_interactions(scene)
    found = []
    for a, agent in enumerate(scene.agents):
        if agent.path is None:
            found += _waits_of(scene, interactions, lines, a)
    return sorted(found, key=lambda wait: -wait.lost)


def waiting(scene: Scene, found: Sequence[Wait]) -> Section:
    """The waits, and who is waited for most."""
    if not found:
        return Section("waits", "Waiting", "Nobody waits or holds back for anybody.")
    lost: dict[str, list[float]] = {}
    for wait in found:
        if wait.meeting is not None:
            lost.setdefault(wait.meeting.agent, []).append(wait.lost)
    slow = len({wait.agent for wait in found})
    verb = "wait or hold back" if slow > 1 else "waits or holds back"
    lead = f"{slow} of {count(len(scene.agents), 'agent')} {verb}"
    if lost:
        most = max(lost, key=lambda name: sum(lost[name]))
        lead += f"; {most} is waited for most, {sum(lost[most]):.1f} s in all"
    return Section("waits", "Waiting", f"{lead}:", found)


def _waits_of(scene: Scene, interactions: Interactions, lines: WorldLines, a: int) -> list[Wait]:
    curve = lines.curve(a)
    step = np.diff(curve, axis=0)
    lengths = np.hypot(step[:, 0], step[:, 1])
    duration = float(curve[-1, 2] - curve[0, 2])
    pace = float(lengths.sum()) / duration
    if pace <= 0:
        return []
    slow = np.concatenate([[False], lengths < SLOW * pace * step[:, 2], [False]])
    edges = np.flatnonzero(slow[1:] != slow[:-1])
    found = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        begin, end = float(curve[first, 2]), float(curve[last, 2])
        length = float(lengths[first:last].sum())
        lost = end - begin - length / pace
        if lost < LEAST_LOSS * duration:
            continue
        middle = [float(np.interp((begin + end) / 2, curve[:, 2], curve[:, x])) for x in (0, 1)]
        going_on = _going_on(curve[first:], lengths[first:], pace)
        meeting = (
            None if going_on is None else _first_meeting(scene, interactions, lines, a, going_on)
        )
        wait = Wait(
            scene.agents[a].id, begin, end, lost, length / (end - begin), pace,
            (middle[0], middle[1]), meeting,
        )  # fmt: skip
        agent = scene.agents[a]
        # Some have to be slow, whoever is there: to set off, or at a waypoint for a while.
        free = not agent.visits and agent.max_acceleration is None
        if wait.meeting is not None or (wait.is_wait and free):
            found.append(wait)
    return found


def _going_on(rest: FloatArray, lengths: FloatArray, pace: float) -> FloatArray | None:
    """The rest of a curve (n, 3) walked at `pace` (m/s); None where there is no way left."""
    moves = np.concatenate([[True], lengths > 0])
    if moves.sum() < 2:
        return None
    path = rest[moves].copy()
    path[1:, 2] = rest[0, 2] + np.cumsum(lengths[lengths > 0]) / pace
    return path


def _first_meeting(
    scene: Scene, interactions: Interactions, lines: WorldLines, a: int, curve: FloatArray
) -> Meeting | None:
    """The first agent that `curve` would bring agent `a` too near to."""
    others = [b for b in range(len(scene.agents)) if interactions.collides[a, b]]
    if not others:
        return None
    crowd = WorldLines.from_curves(
        [scene.agents[b].id for b in (a, *others)], [curve, *(lines.curve(b) for b in others)]
    )
    leaves = np.array(
        [
            scene.final_time
            if scene.agents[b].after_arrival == "stay"
            else float(crowd.curve(k)[-1, 2])
            for k, b in enumerate((a, *others))
        ]
    )
    wanted = np.zeros((len(leaves), len(leaves)), dtype=bool)
    wanted[0, 1:] = True
    found = nearest_moments(crowd, leaves, wanted)
    overlap = interactions.distance[a, others] - found.distance
    near = np.flatnonzero(overlap > 0)
    if not len(near):
        return None
    first = int(near[np.argmin(found.instant[near])])
    when = float(found.instant[first])
    place = [float(np.interp(when, curve[:, 2], curve[:, x])) for x in (0, 1)]
    return Meeting(crowd.agent_ids[first + 1], float(overlap[first]), when, (place[0], place[1]))
