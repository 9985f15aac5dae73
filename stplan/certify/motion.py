"""Greatest speed and acceleration of a curve, and whether it visits its waypoints as asked.

Motion is straight at constant speed between knots, so speed is that of segments. Velocity jumps at knots,
so an acceleration has to be defined: the change of velocity at a knot over the time between the middles of
its two segments, but over no more than an eighth of the time from start to arrival (`LONGEST_SHARE`).
Before the first and after the last knot an agent with such a limit is at rest (before the first one at its
`start_velocity`, where it has one), half a segment from that segment's middle.

But for the eighth, any smooth motion through the knots at their times accelerates at least so much
somewhere around the knot (mean value theorem). An agent that changes its velocity evenly around a knot, at
a rate a for a time w, strays from the curve by a w^2 / 8. Without the eighth, a curve of few long segments
would hide any acceleration in a large w.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stplan.amounts import distinct
from stplan.arrays import FloatArray
from stplan.scene.model import Agent, Visit

# A waypoint counts as passed, a prescribed path as followed, within this share of the agent's radius.
PLACE_SHARE = 1e-6
# Limits count as kept up to this relative excess, which is rounding; times up to this share of the curve's.
ROUNDING = 1e-9
# A change of velocity takes at most this share of the time from start to arrival.
LONGEST_SHARE = 1.0 / 8.0


@dataclass(frozen=True)
class Peak:
    """How near an agent comes to a limit of its motion, and when (s).

    Attributes:
        coarse: whether it is the length of segments alone that breaks the limit.
    """

    agent: str
    limit: str
    allowed: float
    reached: float
    time: float
    coarse: bool = False

    @property
    def holds(self) -> bool:
        """Whether the limit is kept."""
        return self.reached <= self.allowed * (1.0 + ROUNDING)

    def __str__(self) -> str:
        """In words."""
        unit = "m/s" if self.limit == "speed" else "m/s2"
        reached, allowed = distinct(self.reached, self.allowed, digits=6)
        sentence = (
            f"{self.agent}: {self.limit} {reached} {unit} at t = {self.time:.6g} s; "
            f"at most {allowed} {unit} is allowed"
        )
        if self.coarse:
            sentence += (
                ", and its segments are too long to tell more: the change counts as lasting "
                f"{LONGEST_SHARE:g} of its time; give it more knots"
            )
        return sentence


def motion_peaks(agent: Agent, curve: FloatArray, *, comes_to_rest: bool = True) -> list[Peak]:
    """Speed and acceleration of `curve` (n + 1, 3) where the agent has limits."""
    peaks = []
    step = np.diff(curve, axis=0)
    velocity = step[:, :2] / step[:, 2:]
    if agent.max_speed is not None:
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        worst = int(speed.argmax())
        when = 0.5 * float(curve[worst, 2] + curve[worst + 1, 2])
        peaks.append(Peak(agent.id, "speed", agent.max_speed, float(speed[worst]), when))
    if agent.max_acceleration is not None:
        before = np.array(agent.start_velocity or (0.0, 0.0))
        rest = np.zeros(2) if comes_to_rest else velocity[-1]
        change = np.diff(np.vstack([before, velocity, rest]), axis=0)
        half = np.concatenate([[0.0], 0.5 * step[:, 2], [0.0]])
        longest = LONGEST_SHARE * float(curve[-1, 2] - curve[0, 2])
        between, jump = half[:-1] + half[1:], np.hypot(change[:, 0], change[:, 1])
        acceleration = jump / np.minimum(between, longest)
        worst = int(acceleration.argmax())
        limit, reached = agent.max_acceleration, float(acceleration[worst])
        peak = Peak(agent.id, "acceleration", limit, reached, float(curve[worst, 2]))
        coarse = not peak.holds and float((jump / between).max()) <= limit
        peaks.append(replace(peak, coarse=coarse))
    return peaks


def place_tolerance(agent: Agent, curve: FloatArray) -> float:
    """Within what distance places of `curve` count as the same, m: no less than coordinates can tell."""
    return PLACE_SHARE * agent.radius + 4.0 * float(np.spacing(np.abs(curve[:, :2]).max()))


def time_tolerance(curve: FloatArray) -> float:
    """Up to what difference times of `curve` count as the same, s."""
    rounding = 4.0 * float(np.spacing(np.abs(curve[:, 2]).max()))
    return ROUNDING * float(curve[-1, 2] - curve[0, 2]) + rounding


def missed_visit(agent: Agent, curve: FloatArray) -> str:
    """What is wrong with the first waypoint that is not visited in order and as asked, or ""."""
    visits = agent.visits or (Visit(),) * len(agent.waypoints)
    tolerance, late = place_tolerance(agent, curve), time_tolerance(curve)
    now = -np.inf
    for number, (point, visit) in enumerate(zip(agent.waypoints, visits, strict=True), start=1):
        begin, end = visit.window or (-np.inf, np.inf)
        begin = max(begin, now)
        for enter, leave in _stays(curve, point, tolerance):
            arrives = max(begin, enter)
            if arrives + visit.dwell <= min(end, leave) + late:
                now = arrives + visit.dwell
                break
        else:
            return _missed(agent.id, number, point, visit)
    return ""


def _missed(name: str, number: int, point: tuple[float, float], visit: Visit) -> str:
    what = f"{name}: does not pass waypoint {number} {point} in order"
    if visit.window is not None:
        what += f" between {visit.window[0]:g} and {visit.window[1]:g} s"
    if visit.dwell > 0:
        what += f", staying there for {visit.dwell:g} s"
    return what


def _stays(
    curve: FloatArray, point: tuple[float, float], tolerance: float
) -> list[tuple[float, float]]:
    """When a curve is within `tolerance` (m) of `point`: intervals [enter, leave] in s, in order."""
    start, step = curve[:-1], np.diff(curve, axis=0)
    squared = (step[:, :2] ** 2).sum(axis=1)
    moves = squared > 0
    safe = np.where(moves, squared, 1.0)
    along = ((point - start[:, :2]) * step[:, :2]).sum(axis=1) / safe
    across = tolerance**2 - ((start[:, :2] + along[:, None] * step[:, :2] - point) ** 2).sum(axis=1)
    half = np.sqrt(np.maximum(across, 0.0) / safe)
    first = np.where(moves, np.maximum(along - half, 0.0), 0.0)
    last = np.where(moves, np.minimum(along + half, 1.0), 1.0)
    near = np.hypot(*(start[:, :2] - point).T) <= tolerance
    stays: list[tuple[float, float]] = []
    for k in np.flatnonzero(np.where(moves, (across >= 0) & (first <= last), near)):
        enter = float(start[k, 2] + first[k] * step[k, 2])
        leave = float(curve[k + 1, 2] if last[k] == 1.0 else start[k, 2] + last[k] * step[k, 2])
        if stays and enter <= stays[-1][1]:
            stays[-1] = (stays[-1][0], leave)
        else:
            stays.append((enter, leave))
    return stays
