"""The certificate: what every written trajectory promises, checked in continuous time.

Starts, ends and times; distances of every interacting pair at every instant at which both are present;
distances of every path to the walls; waypoints, meetings, limits of motion and given paths. Interactions
that the scene switches off are counted, not demanded.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.certify.meetings import MeetingSpot, meeting_spots
from stplan.certify.motion import PLACE_TOLERANCE, Peak, missed_visit, motion_peaks
from stplan.certify.pair_clearance import nearest_moments
from stplan.certify.wall_clearance import time_at, wall_distance
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import Agent, Scene
from stplan.world import FreeSpace

# Columns of a row in the report.
_COLUMNS = ("a", "b", "clearance", "time", "x", "y")


@dataclass(frozen=True)
class Tightest:
    """A smallest clearance: of whom, how much (m), when (s) and where (m)."""

    who: tuple[str, ...]
    clearance: float
    time: float
    place: tuple[float, float]

    def __str__(self) -> str:
        """In words."""
        return (
            f"{' and '.join(self.who)}: {self.clearance:.4g} m at t = {self.time:.4g} s, "
            f"({self.place[0]:.4g}, {self.place[1]:.4g})"
        )


@dataclass(frozen=True)
class Certificate:
    """The outcome of the check.

    Attributes:
        violations: one sentence for every broken promise, none where the certificate holds.
        pairs: smallest clearance of every demanded pair, in scene order.
        walls: smallest clearance of every agent that heeds walls.
        ignored_pairs, ignored_walls: how many interactions the scene switches off.
        limits: greatest speed and acceleration of every agent that has a limit.
        meetings: the nearest moment of every pair that has to meet.
    """

    violations: tuple[str, ...]
    pairs: tuple[Tightest, ...]
    walls: tuple[Tightest, ...]
    ignored_pairs: int
    ignored_walls: int
    limits: tuple[Peak, ...] = ()
    meetings: tuple[MeetingSpot, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether every promise is kept."""
        return not self.violations

    @property
    def smallest(self) -> Tightest | None:
        """The tightest spot of all, None where nothing interacts."""
        spots = [*self.pairs, *self.walls]
        return min(spots, key=lambda spot: spot.clearance) if spots else None

    @property
    def summary(self) -> str:
        """One line."""
        verdict = "holds" if self.holds else f"IS BROKEN ({len(self.violations)} violations)"
        spot = "nothing interacts" if self.smallest is None else f"tightest {self.smallest}"
        return f"certificate {verdict}; {spot}"

    def as_dict(self) -> dict[str, Any]:
        """For report.json: rows in the order of `columns`, clearances in m, times in s."""

        def row(spot: Tightest) -> list[Any]:
            return [*spot.who, spot.clearance, spot.time, *spot.place]

        return {
            "holds": self.holds,
            "violations": list(self.violations),
            "smallest_clearance": None if self.smallest is None else row(self.smallest),
            "pairs": {"columns": list(_COLUMNS), "rows": [row(spot) for spot in self.pairs]},
            "walls": {
                "columns": ["agent", *_COLUMNS[2:]],
                "rows": [row(spot) for spot in self.walls],
            },
            "limits": {
                "columns": ["agent", "limit", "allowed", "reached", "time"],
                "rows": [[p.agent, p.limit, p.allowed, p.reached, p.time] for p in self.limits],
            },
            "meetings": {
                "columns": ["a", "b", "within", "distance", "time", "x", "y"],
                "rows": [[*m.who, m.within, m.distance, m.time, *m.place] for m in self.meetings],
            },
            "not_demanded": {"pairs": self.ignored_pairs, "walls": self.ignored_walls},
        }


def certify(scene: Scene, free_space: FreeSpace | None, lines: WorldLines) -> Certificate:
    """Check `lines` (in any agent order) against `scene`."""
    missing = _agents_that_differ(scene, lines)
    if missing:
        return Certificate(tuple(missing), (), (), 0, 0)
    place = {agent_id: a for a, agent_id in enumerate(lines.agent_ids)}
    curves = [lines.curve(place[agent.id]) for agent in scene.agents]
    violations = [
        sentence
        for agent, curve in zip(scene.agents, curves, strict=True)
        for sentence in _broken_ends(agent, curve)
    ]
    if violations:
        # Distances of curves that run back in time would mean nothing.
        return Certificate(tuple(violations), (), (), 0, 0)
    pairs, ignored_pairs, close = _check_pairs(scene, curves)
    walls, ignored_walls, through = _check_walls(scene, free_space, curves)
    peaks = [
        peak
        for agent, curve in zip(scene.agents, curves, strict=True)
        for peak in motion_peaks(agent, curve)
    ]
    meetings = meeting_spots(scene, curves, _leaves(scene, curves))
    broken = [str(peak) for peak in peaks if not peak.holds]
    broken += [str(meeting) for meeting in meetings if not meeting.holds]
    return Certificate(
        tuple(close + through + broken), pairs, walls, ignored_pairs, ignored_walls,
        tuple(peaks), tuple(meetings),
    )  # fmt: skip


def _agents_that_differ(scene: Scene, lines: WorldLines) -> list[str]:
    wanted = [agent.id for agent in scene.agents]
    found = list(lines.agent_ids)
    sentences = [f"{name}: has no trajectory" for name in wanted if name not in set(found)]
    sentences += [f"{name}: is not in the scene" for name in found if name not in set(wanted)]
    if len(set(found)) != len(found):
        sentences.append("an agent has more than one trajectory")
    return sentences


def _broken_ends(agent: Agent, curve: FloatArray) -> list[str]:
    """Promise 1 and 4 for one agent: ends, times, waypoints, a given path."""
    if len(curve) < 2 or not np.isfinite(curve).all():
        return [f"{agent.id}: needs at least two finite knots"]
    sentences = []
    if (np.diff(curve[:, 2]) <= 0).any():
        knot = int(np.flatnonzero(np.diff(curve[:, 2]) <= 0)[0]) + 1
        sentences.append(f"{agent.id}: time does not increase at knot {knot}")
    if tuple(curve[0]) != (*agent.start, agent.start_time):
        sentences.append(
            f"{agent.id}: starts at {tuple(curve[0].tolist())}, "
            f"not at {(*agent.start, agent.start_time)}"
        )
    if tuple(curve[-1, :2]) != agent.goal:
        sentences.append(
            f"{agent.id}: ends at {tuple(curve[-1, :2].tolist())}, not at {agent.goal}"
        )
    if curve[-1, 2] > agent.max_time:
        sentences.append(f"{agent.id}: arrives at {curve[-1, 2]} s, after {agent.max_time} s")
    if sentences:
        return sentences
    missed = missed_visit(agent, curve)
    if missed:
        return [missed]
    if agent.path is not None:
        given = np.array(agent.path)
        times = np.union1d(given[:, 2], curve[:, 2])
        gap = max(
            np.abs(
                np.interp(times, given[:, 2], given[:, x])
                - np.interp(times, curve[:, 2], curve[:, x])
            ).max()
            for x in range(2)
        )
        if gap > PLACE_TOLERANCE or curve[-1, 2] != given[-1, 2]:
            return [f"{agent.id}: leaves its given path by {gap:.3g} m"]
    return []


def _leaves(scene: Scene, curves: list[FloatArray]) -> FloatArray:
    """(A,) until when every agent is present, s."""
    return np.array(
        [
            scene.final_time if agent.after_arrival == "stay" else curve[-1, 2]
            for agent, curve in zip(scene.agents, curves, strict=True)
        ]
    )


def _check_pairs(
    scene: Scene, curves: list[FloatArray]
) -> tuple[tuple[Tightest, ...], int, list[str]]:
    interactions = scene_interactions(scene)
    lines = WorldLines.from_curves([agent.id for agent in scene.agents], curves)
    found = nearest_moments(lines, _leaves(scene, curves), interactions.collides)
    needs = interactions.distance[found.pairs[:, 0], found.pairs[:, 1]]
    columns = (found.pairs, found.distance, needs, found.instant, found.middle)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    ignored = len(curves) * (len(curves) - 1) // 2 - len(found.pairs)
    spots, sentences = [], []
    for (a, b), gap, needed, when, (x, y) in rows:
        if not np.isfinite(gap):
            continue
        names = (scene.agents[a].id, scene.agents[b].id)
        spot = Tightest(names, gap - needed, when, (x, y))
        spots.append(spot)
        if gap <= needed:
            sentences.append(
                f"{names[0]} and {names[1]}: {gap:.6g} m apart at t = {when:.6g} s, "
                f"({x:.4g}, {y:.4g}); more than {needed:.6g} m is needed"
            )
    return tuple(spots), ignored, sentences


def _check_walls(
    scene: Scene, free_space: FreeSpace | None, curves: list[FloatArray]
) -> tuple[tuple[Tightest, ...], int, list[str]]:
    if free_space is None:
        return (), 0, []
    spots, sentences, ignored = [], [], 0
    for agent, curve in zip(scene.agents, curves, strict=True):
        if agent.weights.wall == 0:
            ignored += 1
            continue
        distance, place = wall_distance(free_space, curve)
        when = time_at(curve, place)
        spot = Tightest(
            (agent.id,), distance - agent.radius, when, (float(place[0]), float(place[1]))
        )
        spots.append(spot)
        if distance <= agent.radius:
            where = f"at t = {when:.6g} s, ({place[0]:.4g}, {place[1]:.4g})"
            sentences.append(
                f"{agent.id}: leaves the free space {where}"
                if distance < 0
                else f"{agent.id}: {distance:.6g} m from a wall {where}; "
                f"more than its radius {agent.radius:.6g} m is needed"
            )
    return tuple(spots), ignored, sentences
