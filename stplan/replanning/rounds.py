"""A scene whose goals move, played: every `replan_every` seconds all decide and choose a short motion.

One after another they choose, from a fan of short motions that end at rest, the one that leads nearest to
what they want and keeps clear of the walls and of what all others have chosen to do. What an agent chose
last is one of them, so that nobody is ever left without a motion that is clear until everybody stands.

Whoever does not see all others keeps clear of those it sees. Of two who have to keep a distance R, and of
whom one does not see the other, both choose motions no longer than (s - R) / 2, s the shorter of their
sights: they are further apart than s, so they stand before they could touch, and see each other before.
What walls hide is treated likewise (`stplan.replanning.sight`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.callbacks import Stop, never
from stplan.certify.play import first_within
from stplan.replanning.decisions import Decisions, Field, Wish
from stplan.replanning.motions import SHARES, Limits, arrivals, fan
from stplan.replanning.sight import Hiding
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene
from stplan.scene.moving_goals import REPLAN_EVERY, captures
from stplan.world import FreeSpace

# Longest step of the grid of times, s; and how many of them there are between decisions at least.
LONGEST_STEP = 0.125
LEAST_STEPS = 2
# Motions aim at a velocity for one time between decisions, or for so many.
WINDOWS = (1, 2)
# Distances are kept with this much to spare, as a share of them.
ROOM = 1e-6
# How much who evades minds a metre too near to a pursuer, in metres of way.
FEAR = 20.0
# Who has stood for so many rounds short of its goal goes around those who are in its way for so many rounds.
PATIENCE, DETOUR = 2, 6
# A motion has to lead this much nearer than the one before in the order of the fan, m.
BETTER = 1e-9


@dataclass(frozen=True)
class Caught:
    """Who was caught, by whom, and when (s)."""

    prey: int
    pursuer: int
    time: float


@dataclass(frozen=True)
class Played:
    """What happened.

    Attributes:
        curves: of every agent (n, 3).
        rounds: how often all decided.
    """

    curves: tuple[FloatArray, ...]
    caught: tuple[Caught, ...]
    rounds: int


def play(scene: Scene, space: FreeSpace, stop: Stop = never) -> Played | None:
    """What happens in `scene` in a free space; None where `stop` says so before the end."""
    game = _Game(scene, space)
    while game.now < game.last:
        if stop():
            return None
        game.round()
    return game.played()


class _Game:
    """Where everybody is at every step of the grid of times, as far as it has been chosen."""

    def __init__(self, scene: Scene, space: FreeSpace) -> None:
        self._field = Field.of(scene, space)
        self._scene = scene
        agents, count = scene.agents, len(scene.agents)
        every = scene.replan_every or REPLAN_EVERY
        self._steps = max(int(np.ceil(every / LONGEST_STEP)), LEAST_STEPS)
        self._step = every / self._steps
        self._begin = agents[0].start_time
        self.last = max(int((scene.horizon - self._begin) / self._step * (1.0 + 1e-12)), 1)
        self._limits = [
            Limits(one.max_speed or 1.0, one.max_acceleration or np.inf, self._step)
            for one in agents
        ]
        pairs = PairSettings(scene).between(np.arange(count), np.arange(count))
        self._apart = np.where(pairs.collides, (1.0 + ROOM) * pairs.distance, 0.0)
        starts = np.array([agent.start for agent in agents])
        self._places = np.repeat(starts[:, None], self.last + 1, axis=1)
        self._present = np.ones(count, dtype=bool)
        self._sight = np.array([np.inf if one.sight is None else one.sight for one in agents])
        mutual = np.minimum(self._sight[:, None], self._sight[None, :])
        spare = np.where(self._apart > 0.0, 0.5 * (mutual - self._apart), np.inf)
        # How far each may go until it stands.
        self._longest = (1.0 - ROOM) * spare.min(axis=1)
        self._hiding = Hiding(scene, space, self._apart)
        self._seen = np.ones((count, count), dtype=bool)
        self._caught: list[Caught] = []
        self._captures = captures(scene)
        self._goals = np.array(
            [one.goal if one.moving_goal is None else (np.nan, np.nan) for one in agents]
        )
        # For how many rounds each has stood, and still goes around others.
        self._stood = np.zeros(count, dtype=np.int64)
        self._detour = np.zeros(count, dtype=np.int64)
        self.now = 0
        self._rounds = 0

    def round(self) -> None:
        """All decide and choose, and move until they do so again."""
        now, self._rounds = self.now, self._rounds + 1
        velocities = self._velocities(now)
        here = self._places[:, now]
        gaps = np.hypot(*np.moveaxis(here[:, None] - here[None], -1, 0))
        self._seen = self._present[None, :] & (gaps <= self._sight[:, None])
        self._seen &= self._hiding.seen(here)
        self._lose_patience(here)
        decisions = Decisions(self._field, here, velocities, self._seen)
        wishes = [
            decisions.wish(a, self._apart[a] if self._detour[a] else None)
            if self._present[a]
            else None
            for a in range(len(self._present))
        ]
        for a in np.flatnonzero(self._present).tolist():
            self._choose(a, wishes[a], velocities[a])
        self.now = min(now + self._steps, self.last)
        self._catch(now)

    def _lose_patience(self, here: FloatArray) -> None:
        """Who has stood for long short of its goal goes around others for a while."""
        before = self._places[:, max(self.now - self._steps, 0)]
        self._stood = np.where((here == before).all(axis=1), self._stood + 1, 0)
        waits = (here != self._goals).any(axis=1) & np.isfinite(self._goals[:, 0])
        stuck = waits & (self._stood > PATIENCE)
        self._detour = np.where(stuck, DETOUR, np.maximum(self._detour - 1, 0))

    def played(self) -> Played:
        """What happened until now."""
        times = np.minimum(self._begin + self._step * np.arange(self.last + 1), self._scene.horizon)
        ends = {one.prey: one.time for one in self._caught}
        curves = []
        for a, places in enumerate(self._places):
            curve = np.column_stack([places, times])
            if a in ends:
                end = [np.interp(ends[a], times, places[:, x]) for x in range(2)]
                curve = np.vstack([curve[times < ends[a]], [*end, ends[a]]])
            curves.append(curve)
        return Played(tuple(curves), tuple(self._caught), self._rounds)

    def _velocities(self, now: int) -> FloatArray:
        """(A, 2) of the last step, m/s."""
        if now == 0:
            return np.zeros((len(self._places), 2))
        velocities: FloatArray = (self._places[:, now] - self._places[:, now - 1]) / self._step
        return velocities

    def _choose(self, a: int, wish: Wish | None, velocity: FloatArray) -> None:
        """Replace what is to come of an agent by the clear motion that leads nearest to its wish."""
        now, here = self.now, self._places[a, self.now]
        left = self.last - now
        limits, first = self._limits[a], now == 0
        old = self._places[a, now + 1 :]
        if wish is not None and wish.fixed is not None and not (here == wish.fixed).all():
            # It stands for a step at least: whoever is at its goal with the last one brakes in half of it.
            longest = min(WINDOWS[-1] * self._steps + limits.stopping + 1, left - 1)
            for points in arrivals(limits, here, velocity, wish.fixed, longest, first=first):
                rest = np.repeat(points[-1:], left - len(points), axis=0)
                motion = np.vstack([points, rest])[None]
                if self._clear(a, motion)[0]:
                    self._places[a, now + 1 :] = motion[0]
                    return
        towards = np.array([1.0, 0.0])
        if wish is not None:
            way = wish.distances.next_from(here) - here
            towards = way if np.hypot(*way) > 0.0 else towards
        windows = tuple(count * self._steps for count in WINDOWS)
        shares = np.append(SHARES, self._hiding.short_shares(a, here, self._stride(a)))
        velocities = fan(limits, velocity, towards, windows, first=first, shares=shares)
        if wish is None:
            velocities = velocities[:1]
        motions = here + self._step * np.cumsum(velocities, axis=1)
        if motions.shape[1] > left:
            # Who would still move at the end has no time for that motion.
            stands = (velocities[:, left - 1 :] == 0.0).all(axis=(1, 2))
            motions = motions[stands, :left]
        motions = np.concatenate([old[None, : motions.shape[1]], motions])
        worth = self._worth(a, motions, wish)
        for c in np.argsort(worth, kind="stable").tolist():
            if c == 0:
                return
            if self._clear(a, motions[c : c + 1])[0]:
                self._places[a, now + 1 : now + 1 + motions.shape[1]] = motions[c]
                self._places[a, now + 1 + motions.shape[1] :] = motions[c, -1]
                return

    def _worth(self, a: int, motions: FloatArray, wish: Wish | None) -> FloatArray:
        """(C,) how far from its wish each motion (C, L, 2) leaves the agent, m; the least is best."""
        if wish is None:
            return np.linspace(1.0, 0.0, len(motions))
        far = np.maximum(wish.distances.at(np.ascontiguousarray(motions[:, -1])) - wish.enough, 0.0)
        if np.isfinite(self._longest[a]):
            # Where motions are short, how far it gets before all decide again counts as much.
            soon = motions[:, min(self._steps, motions.shape[1]) - 1]
            far = far + np.maximum(wish.distances.at(np.ascontiguousarray(soon)) - wish.enough, 0.0)
            far = far + self._hiding.lost(a, motions[:, -1], self._stride(a))
        for b in wish.threats:
            theirs = self._places[b, self.now + 1 : self.now + 1 + motions.shape[1]]
            gap = np.hypot(*np.moveaxis(motions - theirs, -1, 0)).min(axis=1)
            far = far + FEAR * np.maximum(wish.berth - gap, 0.0)
        return far + BETTER * np.arange(len(motions))

    def _stride(self, a: int) -> float:
        """How far an agent gets between two decisions at most, m."""
        return self._limits[a].speed * self._step * self._steps

    def _clear(self, a: int, motions: FloatArray) -> BoolArray:
        """(C,) which motions (C, L, 2) are short enough, and clear of walls and of what others seen chose."""
        now, here = self.now, self._places[a, self.now]
        whole = np.concatenate([np.broadcast_to(here, (len(motions), 1, 2)), motions], axis=1)
        heads, tails = whole[:, :-1].reshape(-1, 2), whole[:, 1:].reshape(-1, 2)
        clear = self._field.grounds[a].sees(heads, tails).reshape(len(motions), -1).all(axis=1)
        clear &= _lengths(whole) <= self._longest[a]
        clear &= self._hiding.allows(a, whole)
        others = np.flatnonzero(self._seen[a] & (self._apart[a] > 0.0))
        if not len(others):
            return np.asarray(clear)
        steps = min(motions.shape[1], self.last - now)
        theirs = self._places[others, now : now + steps + 1]
        gaps = _least_gaps(whole[:, None, : steps + 1] - theirs[None])
        # Who stands by then may be passed later by who does not; all stand within a motion of their own.
        rest = self._places[others, now + steps :]
        if rest.shape[1] > 1:
            late = _least_gaps(whole[:, None, -1:, :] - rest[None])
            gaps = np.minimum(gaps, late)
        return np.asarray(clear & (gaps > self._apart[a, others]).all(axis=1))

    def _catch(self, before: int) -> None:
        """Take those out of the play who were caught since a step of the grid."""
        times = self._begin + self._step * np.arange(before, self.now + 1)
        found: dict[int, Caught] = {}
        for a, b, capture in self._captures:
            if not (self._present[a] and self._present[b]):
                continue
            one, other = self._places[[a, b], before : self.now + 1]
            when = first_within(one - other, np.asarray(times), capture)
            if when is not None and (b not in found or when < found[b].time):
                found[b] = Caught(b, a, when)
        for caught in sorted(found.values(), key=lambda one: (one.time, one.prey)):
            self._present[caught.prey] = False
            self._caught.append(caught)


def _lengths(ways: FloatArray) -> FloatArray:
    """(C,) lengths of ways (C, L, 2), m."""
    step = np.diff(ways, axis=1)
    return np.asarray(np.hypot(step[..., 0], step[..., 1]).sum(axis=1))


def _least_gaps(offsets: FloatArray) -> FloatArray:
    """Least lengths (...) of offsets (..., L, 2) that are linear between entries; of one entry its own."""
    heads, step = offsets[..., :-1, :], np.diff(offsets, axis=-2)
    squared = (step**2).sum(axis=-1)
    share = -(heads * step).sum(axis=-1) / np.where(squared > 0.0, squared, 1.0)
    nearest = heads + np.clip(share, 0.0, 1.0)[..., None] * step
    return np.asarray(np.sqrt((nearest**2).sum(axis=-1)).min(axis=-1))
