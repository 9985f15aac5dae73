"""Robots that are given one task after another: plans reach some way ahead, and grow as time goes on.

Every `replan_every` seconds whoever's plan ends within the next `WINDOW` seconds is planned on, to its next
task and through its service there, among the plans of all others. Every plan ends at a point at which its
robot can stay for good, whatever the others do that is planned: where one window ends nobody has to move.
A robot for whose task there is no plan, for somebody stands there or is in its way, waits; where its own plan
has run out it goes to its goal, out of the way, and turns round as soon as there is one. If all have places
that are in nobody's way, somebody can go on at any time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, Point
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.replanning.trips import Trips
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene
from stplan.scene.moving_goals import REPLAN_EVERY
from stplan.scene.tasks import WINDOW, RobotTask
from stplan.seeding.search.way_timing import timed_way
from stplan.world import FreeSpace

# Longest step of the grid of times, s.
LONGEST_STEP = 0.125
# Who comes no later than this after its shortest way looks for no other, s.
PATIENCE = 1.0
# Nobody is planned to come later than this after it, s: until then others may have gone on.
LONGEST_WAIT = 10.0
# Of the shared tasks so many nearest ones are looked at, and so many with the shortest ways tried.
NEAR, TRIED = 8, 3
# Whoever's next task cannot be planned asks again after this share of what is left of its plan.
RETRY = 0.2
# Distances are kept with this much to spare, as a share of them.
ROOM = 1e-6
# Points that are this near to the straight line between their neighbours, m, need no knot.
STRAIGHT = 1e-9


@dataclass(frozen=True)
class Rolled:
    """What came of it.

    Attributes:
        curves: of every agent (n, 3); all end at the same time.
        rounds: how often plans were made.
        stuck: a sentence for everybody who can go neither to its task nor to its goal; then curves end there.
    """

    curves: tuple[FloatArray, ...]
    rounds: int
    stuck: tuple[str, ...] = ()


def roll(
    scene: Scene, space: FreeSpace, stop: Stop = never, progress: Progress = unheard
) -> Rolled | None:
    """All tasks of `scene`, done in a free space; None where `stop` says so before the end."""
    fleet = _Fleet(scene, space)
    while not fleet.over:
        if stop():
            return None
        if not fleet.round(progress):
            return fleet.rolled(fleet.blocked())
    return fleet.rolled()


class _Orders:
    """The tasks that are left: everybody's own in their order, and those for whoever is free first."""

    def __init__(self, scene: Scene, trips: Trips) -> None:
        self._agents, self._trips = scene.agents, trips
        self._own: list[deque[RobotTask]] = [deque() for _ in scene.agents]
        index = {agent.id: a for a, agent in enumerate(scene.agents)}
        for task in scene.tasks:
            if task.agent is not None:
                self._own[index[task.agent]].append(task)
        self._shared = [task for task in scene.tasks if task.agent is None]

    @property
    def total(self) -> int:
        """How many there are."""
        return sum(map(len, self._own)) + len(self._shared)

    def left(self, a: int) -> bool:
        """Whether there is one for an agent."""
        return bool(self._own[a] or self._shared)

    def offered(self, a: int, here: FloatArray) -> list[RobotTask]:
        """What an agent may do next: its own next task, or the shared ones nearest to `here` (2,)."""
        if self._own[a]:
            return [self._own[a][0]]
        points = dict.fromkeys(task.at for task in self._shared)
        near = sorted(points, key=lambda at: float(np.hypot(*(here - at))))[:NEAR]
        lengths = {at: self._trips.steps(self._agents[a], here, at) for at in near}
        chosen = sorted(near, key=lengths.__getitem__)[:TRIED]
        return [next(task for task in self._shared if task.at == at) for at in chosen]

    def take(self, a: int, task: RobotTask) -> None:
        """An agent does a task that it was offered."""
        if task.agent is None:
            self._shared.remove(task)
        else:
            self._own[a].popleft()


class _Fleet:
    """Where everybody is at every step of the grid of times, as far as it is planned."""

    def __init__(self, scene: Scene, space: FreeSpace) -> None:
        self._scene, agents = scene, scene.agents
        count = len(agents)
        every = scene.replan_every or REPLAN_EVERY
        self._every = max(int(np.ceil(every / LONGEST_STEP)), 1)
        self._step = every / self._every
        self._begin = agents[0].start_time
        self._trips = Trips(space, self._step)
        pairs = PairSettings(scene).between(np.arange(count), np.arange(count))
        self._apart = np.where(pairs.collides, (1.0 + ROOM) * pairs.distance, 0.0)
        starts = np.array([agent.start for agent in agents])
        # Steps beyond the end of a plan repeat its last place.
        self._places = np.repeat(starts[:, None], self._steps(WINDOW) + 1, axis=1)
        self._ends = np.zeros(count, dtype=np.int64)
        self._orders = _Orders(scene, self._trips)
        self._leaving = np.zeros(count, dtype=bool)
        # When a robot whose next task could not be planned asks for it again.
        self._again = np.zeros(count, dtype=np.int64)
        self._now = 0
        self._rounds = 0
        self._said = 0

    @property
    def over(self) -> bool:
        """Whether everybody is at its goal, and nothing is left to do."""
        return not any(map(self._unfinished, range(len(self._ends)))) and bool(
            (self._ends <= self._now).all()
        )

    def round(self, progress: Progress) -> bool:
        """Plan on whoever's plan ends soon, and let time go on; False where nobody can go on any more."""
        self._rounds += 1
        until = self._now + self._steps(WINDOW)
        planned = False
        waiting = list(range(len(self._ends)))
        while waiting:
            # Whoever's plan ends first goes first: shared tasks are for whoever is free first.
            a = min(waiting, key=lambda one: (int(self._ends[one]), one))
            due = self._unfinished(a) and (self._ends[a] < until or self._leaving[a])
            if due and self._again[a] <= self._now and self._planned_on(a):
                planned = True
            else:
                waiting.remove(a)
                if due and self._again[a] <= self._now:
                    # The longer its plan lasts the less it matters when there is more of it.
                    left = max(int(self._ends[a]) - self._now, 0) if not self._leaving[a] else 0
                    self._again[a] = self._now + int(RETRY * left)
        if not planned and (self._ends <= self._now).all():
            return False
        self._now += self._every
        self._say(progress)
        return True

    def blocked(self) -> tuple[str, ...]:
        """A sentence for everybody who cannot go on."""
        sentences = []
        for a, agent in enumerate(self._scene.agents):
            if self._unfinished(a):
                x, y = next(iter(self._next_tasks(a)), RobotTask(None, agent.goal, 0.0)).at
                sentences.append(f"{agent.id} cannot get to ({x:g}, {y:g})")
        return tuple(sentences)

    def rolled(self, stuck: tuple[str, ...] = ()) -> Rolled:
        """What was executed."""
        last = max(int(self._ends.max()), 1)
        self._reserve(last)
        times = self._begin + self._step * np.arange(last + 1)
        curves = [_few_knots(np.column_stack([own[: last + 1], times])) for own in self._places]
        return Rolled(tuple(curves), self._rounds, stuck)

    def _steps(self, seconds: float) -> int:
        """So many steps of the grid last for so many seconds at least."""
        return int(np.ceil(seconds / self._step * (1.0 - 1e-12)))

    def _unfinished(self, a: int) -> bool:
        """Whether an agent has a task left, or is not planned to its goal."""
        return self._orders.left(a) or not self._ends_at_goal(a)

    def _next_tasks(self, a: int) -> list[RobotTask]:
        """What an agent may do next, from where its plan ends or where it turns round."""
        return self._orders.offered(a, self._places[a, -1 if not self._leaving[a] else self._now])

    def _ends_at_goal(self, a: int) -> bool:
        x, y = self._places[a, -1].tolist()
        return (x, y) == self._scene.agents[a].goal

    def _planned_on(self, a: int) -> bool:
        """Whether a plan for what an agent has to do next was found."""
        begin = self._now if self._leaving[a] else max(self._now, int(self._ends[a]))
        tasks = self._next_tasks(a)
        for task in tasks:
            if self._went(a, begin, task.at, self._steps(task.service)):
                self._orders.take(a, task)
                self._leaving[a] = False
                return True
        if self._leaving[a] or (tasks and self._ends[a] > self._now) or self._ends_at_goal(a):
            return False
        found = self._went(a, begin, self._scene.agents[a].goal, 0)
        self._leaving[a] = found and bool(tasks)
        # Who is on its way to its goal for want of anything better asks again in the next round.
        return found and not tasks

    def _went(self, a: int, begin: int, goal: Point, stay: int) -> bool:
        """Plan an agent from a step on to a `goal` and `stay` steps there; False where there is no plan."""
        others = np.flatnonzero(self._apart[a] > 0.0)
        self._reserve(max(int(self._ends.max()), begin))
        last = max(int(self._ends[others].max(initial=0)), begin)
        theirs = np.ascontiguousarray(self._places[others, begin : last + 1])
        apart = self._apart[a, others]
        if (np.hypot(*(theirs[:, -1] - goal).T) <= apart).any():
            return False  # Somebody stands there, for all that is planned.
        best: FloatArray | None = None
        enough = latest = never_late = np.iinfo(np.int64).max
        standing = self._ends[others] <= begin
        for points in self._ways(a, self._places[a, begin], goal, theirs, apart):
            if latest == never_late:
                enough = len(points) - 1 + self._steps(PATIENCE)
                latest = len(points) - 1 + self._steps(LONGEST_WAIT)
            if len(points) - 1 > latest or _touches(points, theirs[standing, 0], apart[standing]):
                continue
            arrival, at = timed_way(points, theirs, apart, latest)
            if arrival >= 0:
                best, latest = points[at], arrival - 1
                if arrival <= enough:
                    break
        if best is None:
            return False
        end = begin + len(best) - 1
        self._reserve(end + stay)
        self._places[a, begin : end + 1] = best
        self._places[a, end:] = best[-1]
        self._ends[a] = end + stay
        return True

    def _ways(
        self, a: int, start: FloatArray, goal: Point, theirs: FloatArray, apart: FloatArray
    ) -> Iterator[FloatArray]:
        """Ways of an agent: the shortest, that around those who will stand on it, and others."""
        ways = self._trips.ways(self._scene.agents[a], start, goal)
        direct = next(ways, None)
        if direct is not None:
            yield direct
            yield from self._trips.around(self._scene.agents[a], direct, theirs[:, -1], apart)
            yield from ways

    def _reserve(self, last: int) -> None:
        """Make room for steps up to `last`."""
        missing = last + 1 - self._places.shape[1]
        if missing > 0:
            more = np.repeat(self._places[:, -1:], max(missing, self._places.shape[1]), axis=1)
            self._places = np.concatenate([self._places, more], axis=1)

    def _say(self, progress: Progress) -> None:
        """What is committed, once in a while."""
        if self._now - self._said >= self._steps(WINDOW):
            self._said = self._now
            at = self._begin + self._step * self._now
            progress(f"{at:g} s: {self._orders.total} tasks left to plan")


def _touches(points: FloatArray, bodies: FloatArray, apart: FloatArray) -> bool:
    """Whether one of some `bodies` (B, 2) that stand is within `apart` (B,) of one of some points (n, 2)."""
    gaps = np.hypot(*np.moveaxis(points[:, None] - bodies[None], -1, 0))
    return bool((gaps <= apart).any())


def _few_knots(curve: FloatArray) -> FloatArray:
    """`curve` (n, 3) on an even grid of times without the knots in the middle of straight, even motion."""
    kept = [0]
    step = np.diff(curve[:, :2], axis=0)
    for k in range(1, len(curve) - 1):
        since = kept[-1]
        even = curve[since, :2] + (k - since) * step[since]
        then = curve[since, :2] + (k + 1 - since) * step[since]
        off = max(np.abs(even - curve[k, :2]).max(), np.abs(then - curve[k + 1, :2]).max())
        if off > STRAIGHT:
            kept.append(k)
    return curve[[*kept, len(curve) - 1]]
