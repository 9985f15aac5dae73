"""Where everybody wants to go next, by where the others are and how they move at that moment.

Whoever pursues heads for where the nearest prey will be, at its present velocity, when it gets there. Whoever
follows does so with the one it follows, and comes as near as it has to. Whoever evades runs to the spot that
it reaches before its pursuers, all the way, and that the last of these reaches latest; among given places to
that with the greatest lead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray
from stplan.replanning.ground import Distances, Ground
from stplan.scene.model import Agent, Scene
from stplan.scene.moving_goals import captures
from stplan.scene.places import Place
from stplan.world import FreeSpace

# Others are taken to go on as they do for at most so long, s, or for so much of that as is clear.
AHEAD = 2.0
CLEAR_SHARES = (1.0, 0.75, 0.5, 0.25)
# Whoever follows comes nearer than it has to by this share.
NEARER = 0.6
# Whoever evades wants so many captures between itself and its pursuers on the way.
BERTH = 1.5
# How long before them it wants to be there, s; where there is no such spot, at all.
MARGINS = (0.3, 0.0)
# How often ways are looked for again over those spots alone that are reached before the pursuers.
ROUNDS = 4
# What takes longer, s, is as good as never.
FOREVER = 1e6


@dataclass(frozen=True)
class Wish:
    """What an agent wants next.

    Attributes:
        distances: to where it wants to be.
        enough: how near is as good as there, m.
        threats: whom it wants to keep away from, indices, ...
        berth: ... and how far, m.
        fixed: the goal that it wants to stand on exactly.
    """

    distances: Distances
    enough: float = 0.0
    threats: tuple[int, ...] = ()
    berth: float = 0.0
    fixed: FloatArray | None = None


@dataclass(frozen=True)
class Field:
    """What stays the same while a scene is played.

    Attributes:
        grounds: of every agent; those of one radius share theirs.
        refuges: (N,) which spots of its ground lie in the places of who evades to places, by index.
        reach: how near the pursuers of each prey have to come, by index, m.
    """

    scene: Scene
    grounds: tuple[Ground, ...]
    refuges: Mapping[int, BoolArray]
    reach: Mapping[int, float]

    @staticmethod
    def of(scene: Scene, space: FreeSpace) -> Field:
        """The field of a scene in a free space."""
        of_radius = {r: Ground.of(space, r) for r in sorted({one.radius for one in scene.agents})}
        grounds = tuple(of_radius[agent.radius] for agent in scene.agents)
        refuges = {
            a: _within(agent.moving_goal.places, grounds[a])
            for a, agent in enumerate(scene.agents)
            if agent.moving_goal is not None and agent.moving_goal.places
        }
        reach: dict[int, float] = {}
        for _, prey, capture in captures(scene):
            reach[prey] = max(capture, reach.get(prey, 0.0))
        return Field(scene, grounds, refuges, reach)


def _within(places: Sequence[Place], ground: Ground) -> BoolArray:
    """(N,) which spots lie in a place, or near one where none do."""
    shape = shapely.union_all([place.shape() for place in places])
    distance = shapely.distance(shape, shapely.points(ground.spots))
    return np.asarray(distance <= max(float(distance.min()), 0.0))


class Decisions:
    """What the agents of a field want at one moment.

    Args:
        places, velocities: (A, 2) of all, m and m/s.
        seen: (A, A) which others an agent knows of: those present whom it sees.
    """

    def __init__(
        self, field: Field, places: FloatArray, velocities: FloatArray, seen: BoolArray
    ) -> None:
        self._field, self._agents, self._grounds = field, field.scene.agents, field.grounds
        self._places, self._velocities, self._seen = places, velocities, seen
        self._index = {agent.id: a for a, agent in enumerate(self._agents)}
        self._known: dict[tuple[int, int], Distances] = {}

    def wish(self, a: int, berths: FloatArray | None = None) -> Wish | None:
        """What an agent wants; None where it knows of nobody to want it of.

        `berths` (A,) are how far it goes around others on its way to a point where it has to, m.
        """
        agent = self._agents[a]
        goal = agent.moving_goal
        if goal is None:
            fixed = np.array(agent.goal)
            usable = None if berths is None else self._around(a, berths)
            return Wish(self._grounds[a].distances_to(fixed, usable), fixed=fixed)
        others = [b for name in goal.others if self._seen[a, b := self._index[name]]]
        if not others:
            return None
        if goal.kind == "follow":
            return Wish(
                self._grounds[a].distances_to(self._later(a, others[0], AHEAD / 2)),
                NEARER * goal.within,
            )
        if goal.kind == "pursue":
            return Wish(self._intercept(a, others))
        return self._escape(a, others)

    def _around(self, a: int, berths: FloatArray) -> BoolArray:
        """(N,) which spots are clear of where those are whom an agent sees."""
        spots = self._grounds[a].spots
        usable = np.ones(len(spots), dtype=bool)
        for b in np.flatnonzero(self._seen[a] & (berths > 0.0)).tolist():
            usable &= np.hypot(*(spots - self._places[b]).T) > berths[b]
        return usable

    def _from(self, ground: Ground, a: int) -> Distances:
        """To where an agent is."""
        key = (id(ground), a)
        if key not in self._known:
            self._known[key] = ground.distances_to(self._places[a])
        return self._known[key]

    def _later(self, a: int, other: int, time: float) -> FloatArray:
        """(2,) where `other` is after a time as `a` sees it, unless walls are in its way."""
        here = self._places[other]
        shares = np.array(CLEAR_SHARES)[:, None] * time
        there = here + shares * self._velocities[other]
        clear = np.flatnonzero(self._grounds[a].sees(np.broadcast_to(here, there.shape), there))
        return there[clear[0]] if len(clear) else here

    def _intercept(self, a: int, others: list[int]) -> Distances:
        """To where the prey that is nearest will be."""
        ground, here = self._grounds[a], self._places[a][None]
        lengths = [float(self._from(ground, b).at(here)[0]) for b in others]
        nearest = int(np.argmin(lengths))
        time = min(lengths[nearest] / _speed(self._agents[a]), AHEAD)
        return ground.distances_to(self._later(a, others[nearest], time))

    def _escape(self, a: int, others: list[int]) -> Wish:
        """To where `a` is before all of its pursuers."""
        agent, ground = self._agents[a], self._grounds[a]
        reach = self._field.reach.get(a, agent.radius)
        theirs = np.min(
            [
                np.maximum(self._from(ground, b).of_spots - reach, 0.0) / _speed(self._agents[b])
                for b in others
            ],
            axis=0,
        )
        refuge = self._field.refuges.get(a)
        for margin in MARGINS:
            usable, lead = self._before(a, theirs - margin)
            among = usable & (lead > 0.0)
            among = among if refuge is None else among & refuge
            worth = theirs if refuge is None else lead
            if among.any():
                break
        else:
            usable = np.ones(len(ground.spots), dtype=bool)
            own = self._from(ground, a).of_spots / _speed(agent)
            among, worth = np.isfinite(own), theirs - own
        best = int(np.argmax(np.where(among, np.minimum(worth, FOREVER), -np.inf)))
        way = ground.distances_to(ground.spots[best], usable)
        return Wish(way, 0.0, tuple(others), BERTH * reach)

    def _before(self, a: int, theirs: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Spots (N,) to which `a` gets before times (N,), all the way, and how long before (s)."""
        ground, speed = self._grounds[a], _speed(self._agents[a])
        usable = np.ones(len(ground.spots), dtype=bool)
        for _ in range(ROUNDS):
            own = ground.distances_to(self._places[a], usable).of_spots / speed
            lead = np.where(np.isfinite(own), theirs - own, -np.inf)
            safe = usable & (lead > 0.0)
            if (safe == usable).all():
                break
            usable = safe
        return usable, lead


def _speed(agent: Agent) -> float:
    """m/s; everybody in a play has a limit."""
    return agent.max_speed or 1.0
