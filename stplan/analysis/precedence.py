"""Who passes which spot before whom, and what a delay does where all keep that order.

Curves are cut into pieces. Two pieces of different agents conflict where the places they sweep come as near
as the pair has to keep. Conflicting pieces that overlap in time are halved until none do; then one of every
two is over before the other begins, and that is their order of passing: the second waits at the beginning of
its piece until the first has left its own. Agents that go their ways by these rules, at whatever times, never
are in conflicting pieces at once, so they keep their distances at every instant. Every rule points forward in
time as planned, so there is no circle of agents that wait for each other. docs/method.md has the proof.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.geometry.rod_distances import segment_distances
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene

# Conflicting pieces are at most this share of the distance to be kept long: coarse ones leave no slack.
FINE = 0.125
# They are halved so often, one of them at a time, and into so many; if some still overlap they touch.
HALVINGS, MOST_PIECES = 48, 100_000


@dataclass(frozen=True)
class PassingOrder:
    """One agent is off a spot before another gets there.

    Attributes:
        first, second: who.
        left, entered: until when the first is there and from when on the second, as planned, s.
        place: (x, y) of the second when it enters, m.
    """

    first: str
    second: str
    left: float
    entered: float
    place: tuple[float, float]

    @property
    def slack(self) -> float:
        """By how much the first may be late before the second has to wait, s."""
        return self.entered - self.left


@dataclass(frozen=True)
class Precedence:
    """The order of passing of a plan.

    Attributes:
        passings: those that no other one implies, by time.
        touching: pairs that come so near that no order keeps them apart.
        fixed: who cannot wait, for its motion is prescribed.
        agents: all ids.
    """

    passings: tuple[PassingOrder, ...]
    touching: tuple[tuple[str, str], ...]
    fixed: frozenset[str]
    agents: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "agents": list(self.agents),
            "fixed": sorted(self.fixed),
            "touching": [list(pair) for pair in self.touching],
            "passings": [
                {
                    "first": one.first, "second": one.second, "left": one.left, "entered": one.entered,
                    "slack": one.slack, "place": list(one.place),
                }
                for one in self.passings
            ],
        }  # fmt: skip

    def lateness(self, stopped: str, delay: float) -> dict[str, float]:
        """How late everybody arrives where one agent stops for `delay` s at the worst moment, s.

        Nobody makes up for lost time, so to stop at once is worst for all.
        """
        late: dict[str, list[tuple[float, float]]] = {name: [] for name in self.agents}
        late[stopped].append((-np.inf, delay))
        changed = True
        while changed:
            changed = False
            for one in self.passings:
                value = _at(late[one.first], one.left) - one.slack
                if value > _at(late[one.second], one.entered):
                    late[one.second].append((one.entered, value))
                    changed = True
        return {name: _at(known, np.inf) for name, known in late.items()}


@dataclass(frozen=True)
class Endurance:
    """What delays of up to so many seconds do to a plan whose order of passing is kept.

    Attributes:
        delay: s.
        late: (who, how late at most, whose stop does that), of those who arrive later for another's sake.
        broken: a sentence for everything that goes wrong.
    """

    delay: float
    late: tuple[tuple[str, float, str], ...]
    broken: tuple[str, ...]

    @property
    def survives(self) -> bool:
        """Whether nobody touches anybody."""
        return not self.broken

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        late = [{"agent": who, "late": by, "stopped": whose} for who, by, whose in self.late]
        return {
            "delay": self.delay,
            "survives": self.survives,
            "broken": list(self.broken),
            "late": late,
        }


def endurance(order: Precedence, delay: float) -> Endurance:
    """What comes of any one agent stopping for up to `delay` s at any moment."""
    worst: dict[str, tuple[float, str]] = {}
    for stopped in order.agents:
        if stopped in order.fixed:
            continue
        for name, by in order.lateness(stopped, delay).items():
            if name != stopped and by > worst.get(name, (0.0, ""))[0]:
                worst[name] = by, stopped
    broken = [f"{a} and {b} pass too near each other for any order" for a, b in order.touching]
    broken += [
        f"{name} would have to wait {worst[name][0]:.3g} s for {worst[name][1]}, but its motion is prescribed"
        for name in sorted(order.fixed & worst.keys())
    ]
    late = sorted(
        ((name, *found) for name, found in worst.items()), key=lambda one: (-one[1], one[0])
    )
    return Endurance(delay, tuple(late), tuple(broken))


def longest_delay(order: Precedence) -> float:
    """The longest stop of any one agent that is survived, s; inf where any is.

    Whoever passes before a prescribed motion may be late by what is between them, and nobody is later than
    the one that stops. So the least of these times is survived, and nothing longer.
    """
    if order.touching:
        return 0.0
    slacks = [
        one.slack
        for one in order.passings
        if one.second in order.fixed and one.first not in order.fixed
    ]
    return min(slacks, default=np.inf)


def precedence(scene: Scene, lines: WorldLines) -> Precedence:
    """The order of passing of `lines`, one for every agent of `scene`."""
    curves: Mapping[str, FloatArray] = dict(zip(lines.agent_ids, lines.curves(), strict=True))
    paths = [_Pieces.of(curves[one.id], one.after_arrival != "vanish") for one in scene.agents]
    pairs = np.array(list(combinations(range(len(paths)), 2)), dtype=np.int64).reshape(-1, 2)
    settings = PairSettings(scene)
    pairs = pairs[settings.colliding()[pairs[:, 0], pairs[:, 1]]]
    needs = settings.distances(pairs)
    passings: list[PassingOrder] = []
    touching: list[tuple[str, str]] = []
    for (a, b), need in zip(pairs.tolist(), needs.tolist(), strict=True):
        names = scene.agents[a].id, scene.agents[b].id
        conflicts = _ordered(paths[a], paths[b], need)
        if conflicts is None:
            touching.append(names)
            continue
        forward = conflicts[:, 1] <= conflicts[:, 2]
        passings += _passings(names, conflicts[forward], curves[names[1]])
        passings += _passings(names[::-1], conflicts[~forward][:, [2, 3, 0, 1]], curves[names[0]])
    passings.sort(key=lambda one: (one.entered, one.left, one.first, one.second))
    fixed = frozenset(one.id for one in scene.agents if one.path is not None)
    return Precedence(
        tuple(passings), tuple(touching), fixed, tuple(one.id for one in scene.agents)
    )


@dataclass(frozen=True)
class _Pieces:
    """Pieces of a curve: from `begins` to `ends` (n,) s, in places `heads` to `tails` (n, 2)."""

    begins: FloatArray
    ends: FloatArray
    heads: FloatArray
    tails: FloatArray

    @staticmethod
    def of(curve: FloatArray, stays: bool) -> _Pieces:
        """Its segments, and where it stays in the end."""
        begins, ends, heads, tails = curve[:-1, 2], curve[1:, 2], curve[:-1, :2], curve[1:, :2]
        if stays:
            begins, ends = np.append(begins, curve[-1, 2]), np.append(ends, np.inf)
            heads, tails = np.vstack([heads, curve[-1:, :2]]), np.vstack([tails, curve[-1:, :2]])
        return _Pieces(begins, ends, heads, tails)

    def taken(self, which: IntArray | BoolArray) -> _Pieces:
        """Some of them."""
        return _Pieces(self.begins[which], self.ends[which], self.heads[which], self.tails[which])

    def lengths(self) -> FloatArray:
        """(n,) m."""
        return np.asarray(np.hypot(*(self.tails - self.heads).T))

    def halves(self) -> tuple[_Pieces, _Pieces]:
        """The earlier and the later half of each."""
        when, where = 0.5 * (self.begins + self.ends), 0.5 * (self.heads + self.tails)
        return (
            _Pieces(self.begins, when, self.heads, where),
            _Pieces(when, self.ends, where, self.tails),
        )


def _ordered(one: _Pieces, other: _Pieces, need: float) -> FloatArray | None:
    """(n, 4) begin and end of conflicting pieces of two agents that do not overlap; None where some must."""
    first, second = np.divmod(np.arange(len(one.begins) * len(other.begins)), len(other.begins))
    left, right = one.taken(first), other.taken(second)
    done = [np.empty((0, 4))]
    for _ in range(HALVINGS):
        near = _distances(left, right) <= need
        left, right = left.taken(near), right.taken(near)
        longest = np.maximum(left.lengths(), right.lengths())
        apart = (left.ends <= right.begins) | (right.ends <= left.begins)
        if (~apart & (longest <= 0.0)).any() or len(longest) > MOST_PIECES:
            return None
        apart &= longest <= FINE * need
        done.append(np.column_stack([left.begins, left.ends, right.begins, right.ends])[apart])
        left, right = left.taken(~apart), right.taken(~apart)
        if not len(left.begins):
            return np.vstack(done)
        longer = left.lengths() >= right.lengths()
        parts = [(half, right.taken(longer)) for half in left.taken(longer).halves()]
        parts += [(left.taken(~longer), half) for half in right.taken(~longer).halves()]
        left, right = _joined([a for a, _ in parts]), _joined([b for _, b in parts])
    return None


def _joined(parts: Sequence[_Pieces]) -> _Pieces:
    return _Pieces(
        np.concatenate([part.begins for part in parts]),
        np.concatenate([part.ends for part in parts]),
        np.vstack([part.heads for part in parts]),
        np.vstack([part.tails for part in parts]),
    )


def _distances(one: _Pieces, other: _Pieces) -> FloatArray:
    """(n,) least distance between the segments that pieces sweep, 0 where these cross."""
    count = len(one.begins)
    flat = np.vstack([one.heads, one.tails, other.heads, other.tails])
    positions = np.column_stack([flat, np.zeros(len(flat))])
    points = np.arange(4 * count).reshape(2, 2, count)
    segments = np.ascontiguousarray(points.transpose(0, 2, 1).reshape(-1, 2))
    pairs = np.column_stack([np.arange(count), np.arange(count, 2 * count)])
    return segment_distances(positions, segments, pairs)


def _passings(
    names: tuple[str, str], conflicts: FloatArray, curve: FloatArray
) -> list[PassingOrder]:
    """Those of the (n, 4) conflicts, the first one's times first, that no other one implies."""
    kept: list[PassingOrder] = []
    latest = -np.inf
    # Whoever enters earlier and has to wait for a later leaving waits for all that was left before.
    for _, left, entered, _ in conflicts[np.lexsort((-conflicts[:, 1], conflicts[:, 2]))].tolist():
        if left > latest:
            latest = left
            x, y = (float(np.interp(entered, curve[:, 2], curve[:, axis])) for axis in range(2))
            kept.append(PassingOrder(*names, left, entered, (x, y)))
    return kept


def _at(known: Sequence[tuple[float, float]], time: float) -> float:
    """The lateness known at a time, of entries (from when on, s)."""
    return max((by for since, by in known if since <= time), default=0.0)
