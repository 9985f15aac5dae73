"""How near two agents that have to meet come at a common instant, in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stplan.amounts import distinct, place
from stplan.arrays import FloatArray
from stplan.certify.local_frame import LocalFrame
from stplan.certify.motion import ROUNDING
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import scene_meetings
from stplan.scene.model import Scene


@dataclass(frozen=True)
class MeetingSpot:
    """The nearest moment of a pair that has to meet: distance (m), when (s) and where (m)."""

    who: tuple[str, str]
    within: float
    distance: float
    time: float
    place: tuple[float, float]

    @property
    def holds(self) -> bool:
        """Whether they meet; up to rounding, as limits hold."""
        return self.distance <= self.within * (1.0 + ROUNDING)

    def __str__(self) -> str:
        """In words."""
        names = " and ".join(self.who)
        if not np.isfinite(self.distance):
            return f"{names}: are never both present when they should meet"
        apart, within = distinct(self.distance, self.within, digits=6)
        return (
            f"{names}: come no nearer than {apart} m, at t = {self.time:.6g} s, "
            f"{place(*self.place)}; they should meet within {within} m"
        )


def meeting_spots(
    scene: Scene, lines: WorldLines, leaves: FloatArray, frame: LocalFrame
) -> list[MeetingSpot]:
    """One spot a meeting of the scene.

    Args:
        lines: in scene order, their places in `frame`.
        leaves: (A,) until when each agent is present, s; it stands still after its last knot.
    """
    spots = []
    for meeting in scene_meetings(scene):
        first, second = lines.curve(meeting.first), lines.curve(meeting.second)
        begin = max(first[0, 2], second[0, 2])
        end = min(leaves[meeting.first], leaves[meeting.second])
        if meeting.meet.window is not None:
            begin, end = max(begin, meeting.meet.window[0]), min(end, meeting.meet.window[1])
        who = (scene.agents[meeting.first].id, scene.agents[meeting.second].id)
        spot = _nearest(who, meeting.meet.within, first, second, begin, end)
        x, y = frame.outside(np.array(spot.place)).tolist()
        spots.append(replace(spot, place=(x, y)))
    return spots


def _nearest(
    who: tuple[str, str],
    within: float,
    first: FloatArray,
    second: FloatArray,
    begin: float,
    end: float,
) -> MeetingSpot:
    """On every interval between knots of both the relative position is linear in time."""
    if begin > end:
        return MeetingSpot(who, within, float("inf"), float(begin), (0.0, 0.0))
    knots = np.concatenate([first[:, 2], second[:, 2], [begin, end]])
    times = np.unique(knots[(knots >= begin) & (knots <= end)])
    if len(times) == 1:
        times = np.repeat(times, 2)
    apart = _at(first, times) - _at(second, times)
    step = np.diff(apart, axis=0)
    squared = (step**2).sum(axis=1)
    along = -(apart[:-1] * step).sum(axis=1) / np.where(squared > 0, squared, 1.0)
    along = np.clip(along, 0.0, 1.0)
    distance = np.hypot(*(apart[:-1] + along[:, None] * step).T)
    best = int(distance.argmin())
    when = float(times[best] + along[best] * (times[best + 1] - times[best]))
    middle = 0.5 * (_at(first, np.array([when])) + _at(second, np.array([when])))[0]
    return MeetingSpot(
        who, within, float(distance[best]), when, (float(middle[0]), float(middle[1]))
    )


def _at(curve: FloatArray, times: FloatArray) -> FloatArray:
    """(T, 2) where an agent is at `times` (s)."""
    return np.column_stack([np.interp(times, curve[:, 2], curve[:, x]) for x in range(2)])
