"""Who waits, where, for how long, and for whom: one rule, on arrays.

An agent waits, or holds back, where it is slower than on average over its way. Whom it waits for is found
by letting it go on instead, along its own way at its mean pace: the agent that it would be the first to
come too near to is the one it waits for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.analysis.paths import place_at, segment_lengths
from stplan.arrays import FloatArray
from stplan.certify.pair_clearance import nearest_moments_of
from stplan.problem.world_lines import WorldLines

# Slower than this share of its mean pace an agent holds back, where somebody is in its way.
SLOW = 0.8
# Slower than this share it waits, whoever is in its way.
VERY_SLOW = 0.5
# A wait costs at least this share of the whole travelling time; shorter ones are passed over.
LEAST_LOSS = 0.02


@dataclass(frozen=True)
class Blocker:
    """Whom an agent would have come too near to: by how much (m), when (s) and where (m)."""

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
    meeting: Blocker | None

    @property
    def is_wait(self) -> bool:
        """Whether it is slow enough to be called a wait by itself."""
        return self.speed < VERY_SLOW * self.pace


def waits(crowd: Crowd) -> list[Wait]:
    """Every wait of every agent that finds its own way; the longest come first."""
    found = []
    for a in np.flatnonzero(~crowd.prescribed).tolist():
        found += _waits_of(crowd, a)
    return sorted(found, key=lambda wait: -wait.lost)


def _waits_of(crowd: Crowd, a: int) -> list[Wait]:
    curve = crowd.lines.curve(a)
    lengths = segment_lengths(curve)
    duration = float(curve[-1, 2] - curve[0, 2])
    pace = float(lengths.sum()) / duration
    if pace <= 0:
        return []
    slow = np.concatenate([[False], lengths < SLOW * pace * np.diff(curve[:, 2]), [False]])
    edges = np.flatnonzero(slow[1:] != slow[:-1])
    found = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        begin, end = float(curve[first, 2]), float(curve[last, 2])
        length = float(lengths[first:last].sum())
        lost = end - begin - length / pace
        if lost < LEAST_LOSS * duration:
            continue
        going_on = _going_on(curve[first:], lengths[first:], pace)
        wait = Wait(
            crowd.lines.agent_ids[a], begin, end, lost, length / (end - begin), pace,
            place_at(curve, (begin + end) / 2),
            None if going_on is None else _first_met(crowd, a, going_on),
        )  # fmt: skip
        if wait.meeting is not None or (wait.is_wait and not crowd.unhurried[a]):
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


def _first_met(crowd: Crowd, a: int, curve: FloatArray) -> Blocker | None:
    """The first agent that `curve` would bring agent `a` too near to."""
    knots, first_knots = crowd.lines.knots[:, :2], crowd.lines.offsets[:-1]
    low, high = np.minimum.reduceat(knots, first_knots), np.maximum.reduceat(knots, first_knots)
    kept = crowd.distance[a][:, None]
    within = (low <= curve[:, :2].max(axis=0) + kept) & (high >= curve[:, :2].min(axis=0) - kept)
    others = np.flatnonzero(crowd.collides[a] & within.all(axis=1)).tolist()
    if not others:
        return None
    ids = crowd.lines.agent_ids
    lines = WorldLines.from_curves(
        [ids[b] for b in (a, *others)], [curve, *(crowd.lines.curve(b) for b in others)]
    )
    own = crowd.final_time if crowd.stays[a] else float(curve[-1, 2])
    leaves = np.concatenate([[own], crowd.leaves[others]])
    pairs = np.column_stack([np.zeros(len(others), dtype=np.int64), np.arange(1, len(leaves))])
    found = nearest_moments_of(lines, leaves, pairs)
    overlap = crowd.distance[a, others] - found.distance
    near = np.flatnonzero(overlap > 0)
    if not len(near):
        return None
    first = int(near[np.argmin(found.instant[near])])
    when = float(found.instant[first])
    return Blocker(lines.agent_ids[first + 1], float(overlap[first]), when, place_at(curve, when))
