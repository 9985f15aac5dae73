"""The certificate: what every written trajectory promises, checked in continuous time.

Starts, ends and times; distances of every interacting pair at every instant at which both are present;
distances of every path to the walls; waypoints, meetings, limits of motion and prescribed paths. Interactions
that the scene switches off are counted, not demanded. Distances have to exceed what is asked by more than
rounding could feign (`stplan.certify.local_frame`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stplan.amounts import amount
from stplan.certify.easing import EasedPair
from stplan.certify.ends import agents_that_differ, broken_ends
from stplan.certify.local_frame import LocalFrame
from stplan.certify.meetings import MeetingSpot, meeting_spots
from stplan.certify.motion import Peak, motion_peaks
from stplan.certify.pairs import check_pairs
from stplan.certify.places import broken_assignments
from stplan.certify.tightest import Tightest, Unlisted
from stplan.certify.walls import check_walls
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.scene.presence import present_until
from stplan.wording import count

if TYPE_CHECKING:
    from stplan.world import FreeSpace

# Columns of a row in the report.
_COLUMNS = ("a", "b", "clearance", "time", "x", "y")


@dataclass(frozen=True)
class Certificate:
    """The outcome of the check.

    Attributes:
        violations: one sentence for every broken promise, none where the certificate holds.
        pairs: smallest clearance of every demanded pair, in scene order; in large scenes only those of
            the tightest pairs, the tightest first.
        walls: smallest clearance of every agent that heeds walls.
        ignored_pairs, ignored_walls: how many interactions the scene switches off.
        limits: greatest speed and acceleration of every agent that has a limit.
        meetings: the nearest moment of every pair that has to meet.
        unlisted: what is proven of the pairs that `pairs` leaves out, None where it holds all.
        eased: pairs that start too near each other, where that is allowed, and are clear later.
        rounding: by how much a clearance can be off, m; what is not greater does not count.
    """

    violations: tuple[str, ...]
    pairs: tuple[Tightest, ...]
    walls: tuple[Tightest, ...]
    ignored_pairs: int
    ignored_walls: int
    limits: tuple[Peak, ...] = ()
    meetings: tuple[MeetingSpot, ...] = ()
    unlisted: Unlisted | None = None
    rounding: float = 0.0
    eased: tuple[EasedPair, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether every promise is kept."""
        return not self.violations

    @property
    def num_pairs(self) -> int:
        """How many pairs were looked at: listed, or proven to be further apart than those listed."""
        return len(self.pairs) + (0 if self.unlisted is None else self.unlisted.pairs)

    @property
    def smallest(self) -> Tightest | None:
        """The tightest spot of all, None where nothing interacts."""
        spots = [*self.pairs, *self.walls]
        return min(spots, key=lambda spot: spot.clearance) if spots else None

    @property
    def summary(self) -> str:
        """One line."""
        count = len(self.violations)
        broken = f"IS BROKEN ({count} violation{'' if count == 1 else 's'})"
        verdict = "holds" if self.holds else broken
        spot = "nothing interacts" if self.smallest is None else f"tightest {self.smallest}"
        return f"certificate {verdict}; {spot}{self._eased}"

    @property
    def _eased(self) -> str:
        """Until when agents are too near each other, where they start so."""
        known = [one.clear for one in self.eased if one.clear is not None]
        if not known:
            return ""
        return f"; BEFORE {amount(max(known))} s {count(len(known), 'pair')} too near, being eased apart"

    def as_dict(self) -> dict[str, Any]:
        """For report.json; what is eased apart only where something is."""
        if not self.eased:
            return self._as_dict()
        return self._as_dict() | {
            "eased": {
                "columns": ["a", "b", "apart", "needed", "clear_from"],
                "rows": [[*one.who, one.apart, one.needed, one.clear] for one in self.eased],
            }
        }

    def _as_dict(self) -> dict[str, Any]:
        """For report.json: rows in the order of `columns`, clearances in m, times in s."""

        def row(spot: Tightest) -> list[Any]:
            return [*spot.who, spot.clearance, spot.time, *spot.place]

        pairs: dict[str, Any] = {"columns": list(_COLUMNS), "rows": [row(p) for p in self.pairs]}
        if self.unlisted is not None:
            pairs["others"] = {
                "pairs": self.unlisted.pairs,
                "clearance_above": self.unlisted.clearance,
            }
        return {
            "holds": self.holds,
            "violations": list(self.violations),
            "smallest_clearance": None if self.smallest is None else row(self.smallest),
            "pairs": pairs,
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
            "rounding": self.rounding,
        }


def certify(scene: Scene, free_space: FreeSpace | None, lines: WorldLines) -> Certificate:
    """Check `lines` (in any agent order) against `scene`.

    The work grows with the number of agents and of what is near them, not with all pairs.
    """
    missing = agents_that_differ(scene, lines)
    if missing:
        return Certificate(tuple(missing), (), (), 0, 0)
    place = {agent_id: a for a, agent_id in enumerate(lines.agent_ids)}
    curves = [lines.curve(place[agent.id]) for agent in scene.agents]
    assigned = {a for assignment in scene.assignments for a in assignment.members}
    violations = [
        sentence
        for a, (agent, curve) in enumerate(zip(scene.agents, curves, strict=True))
        for sentence in broken_ends(agent, curve, assigned=a in assigned)
    ]
    if assigned and not violations:
        violations = broken_assignments(scene, np.array([curve[-1, :2] for curve in curves]))
    if violations:
        # Distances of curves that run back in time would mean nothing.
        return Certificate(tuple(violations), (), (), 0, 0)
    frame = LocalFrame.around(
        lines.knots[:, :2], *(() if free_space is None else (free_space.boundary_vertices,))
    )
    ordered = WorldLines.from_curves([agent.id for agent in scene.agents], curves)
    local = ordered.with_knots(frame.local(ordered.knots))
    leaves = present_until(
        np.array([agent.after_arrival == "stay" for agent in scene.agents]),
        np.array([curve[-1, 2] for curve in curves]),
        scene.final_time,
    )
    pairs = check_pairs(scene, local, leaves, frame)
    walls = check_walls(scene, free_space, curves, frame)
    peaks = [
        peak
        for agent, curve in zip(scene.agents, curves, strict=True)
        for peak in motion_peaks(agent, curve)
    ]
    meetings = meeting_spots(scene, local, leaves, frame)
    broken = [str(peak) for peak in peaks if not peak.holds]
    broken += [str(meeting) for meeting in meetings if not meeting.holds]
    return Certificate(
        (*pairs.violations, *walls.violations, *broken), pairs.spots, walls.spots, pairs.ignored,
        walls.ignored, tuple(peaks), tuple(meetings), pairs.unlisted, frame.rounding,
        pairs.eased,
    )  # fmt: skip
