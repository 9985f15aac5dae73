"""Agents that start too near each other, eased apart before anything else is planned.

They are pushed to places nearby at which they are clear of each other, of who else starts then, and of the
walls. They go there straight, all in the same time, and stand for a moment. That much is prescribed: the
others plan around it, and they themselves begin to plan where it ends. What comes of it is one curve each.
Until two of them are clear nothing is demanded of these two, and from then on everything
(`stplan.certify.easing`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.certify.easing import too_near_at_start
from stplan.errors import SeedingError
from stplan.planned import Plan
from stplan.problem.continuation import Curves
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import space_of
from stplan.replanning.stand_ins import StandIns, as_planned, with_stand_ins
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Agent, Scene

if TYPE_CHECKING:
    import shapely

    from stplan.world import FreeSpace

# Places are further apart than they have to be by this share, and looked for so often.
ROOM, ROUNDS = 0.05, 2000
# After so many rounds whoever is in the way is moved as well.
WIDER = 100
# Without a limit they go so many times as fast as they have to on their trip; they stand for this share of
# the time that takes.
HURRY, REST = 3.0, 0.5
# Directions in which agents of one place part: the golden angle, rad.
TURN = np.pi * (3.0 - 5.0**0.5)


@dataclass(frozen=True)
class Easing:
    """A scene whose agents start clear of each other.

    Attributes:
        original: the scene as it is.
        scene: the same with later starts, and stand-ins that make the pieces of the agents eased apart.
        pieces: (n, 3) how these go apart, by id.
    """

    original: Scene
    scene: Scene
    pieces: Mapping[str, FloatArray]

    def joined(self, curves: Curves) -> dict[str, FloatArray]:
        """Curves of the agents of `original`, in its order, from the start, given those of `scene`."""
        return {
            one.id: np.vstack([self.pieces[one.id][:-1], curves[one.id]])
            if one.id in self.pieces
            else curves[one.id]
            for one in self.original.agents
            if one.id in curves
        }


def with_eased_starts(scene: Scene, plan: Callable[[Scene], Plan]) -> Plan:
    """The plan of `scene` by `plan`, a maker of plans, with those eased apart who start too near each other.

    Raises like `plan`; SeedingError where there is no room.
    """
    easing = easing_of(scene)
    if easing is None:
        return plan(scene)
    found = plan(easing.scene)
    seed, lines = (
        None if one is None else _lines(easing, one) for one in (found.seed, found.trajectories)
    )
    if seed is None:
        return found
    return as_planned(scene, found, seed, lines)


def easing_of(scene: Scene, fixed: Collection[str] = ()) -> Easing | None:
    """How those go apart who start too near each other; None where that is not asked, or nobody does.

    Args:
        fixed: ids of agents that stay where they are.

    Raises:
        SeedingError: there is no room for them nearby.
    """
    if scene.overlap != "ease":
        return None
    pairs, _ = too_near_at_start(scene)
    if not len(pairs):
        return None
    space = space_of(scene)
    starts = np.array([agent.start for agent in scene.agents])
    places = _clear_places(scene, space, pairs, fixed)
    moved = np.flatnonzero((places != starts).any(axis=1))
    times = np.array([agent.start_time for agent in scene.agents])
    pieces: dict[str, FloatArray] = {}
    for time in np.unique(times[moved]):
        group = [int(a) for a in moved if times[a] == time]
        lasts = max(
            _duration(scene.agents[a], float(np.hypot(*(places[a] - starts[a])))) for a in group
        )
        for a in group:
            knots = np.vstack([starts[a], places[a], places[a]])
            when = time + lasts * np.array([0.0, 1.0, 1.0 + REST])
            pieces[scene.agents[a].id] = np.column_stack([knots, when])
    agents = [_later(agent, pieces.get(agent.id)) for agent in scene.agents]
    stand_ins = []
    for a, agent in enumerate(scene.agents):
        if agent.id in pieces:
            heeded = np.array([one.id not in pieces for one in scene.agents])
            heeded[pairs[(pairs == a).any(axis=1)]] = False
            stand_ins.append(StandIns(a, [pieces[agent.id]], heeded, stays=False))
    later = replace(scene, agents=tuple(agents), overlap="refuse")
    return Easing(scene, with_stand_ins(later, stand_ins), pieces)


def _lines(easing: Easing, lines: WorldLines) -> WorldLines:
    curves = easing.joined(dict(zip(lines.agent_ids, lines.curves(), strict=True)))
    return WorldLines.from_curves(list(curves), list(curves.values()))


def _later(agent: Agent, piece: FloatArray | None) -> Agent:
    """An agent that begins where its piece ends."""
    if piece is None:
        return agent
    x, y, t = piece[-1].tolist()
    if t >= agent.max_time:
        raise SeedingError(f"{agent.id}: eased apart from others it has no time left for its trip")
    return replace(agent, start=(x, y), start_time=t, start_velocity=None, start_duration=0.0)


def _duration(agent: Agent, far: float) -> float:
    """How long an agent takes over so many metres, from rest to rest, s."""
    trip = float(np.hypot(agent.goal[0] - agent.start[0], agent.goal[1] - agent.start[1]))
    time = agent.max_time - agent.start_time
    speed = HURRY * max(trip, far) / time
    if agent.max_speed is not None:
        speed = min(speed, agent.max_speed)
    lasts = far / speed
    if agent.max_acceleration is not None:
        # Velocities change over half a segment, and over an eighth of the whole curve at most.
        gentle = agent.max_acceleration
        lasts = max(lasts, float(np.sqrt(2.0 * far / gentle)), 8.0 * far / (gentle * time))
    return lasts * (1.0 + 1e-6)


def _clear_places(
    scene: Scene, space: FreeSpace | None, pairs: IntArray, fixed: Collection[str]
) -> FloatArray:
    """(A, 2) starts, of which those too near each other, and as few others as can be, are moved apart.

    Raises:
        SeedingError: there is no room for them nearby.
    """
    starts = np.array([agent.start for agent in scene.agents])
    times = np.array([agent.start_time for agent in scene.agents])
    free = np.array([agent.path is None and agent.id not in fixed for agent in scene.agents])
    everyone = np.arange(len(starts))
    group = np.unique(pairs[np.isin(pairs, np.flatnonzero(free))])
    rooms = _Rooms(scene, space)
    places = starts.copy()
    for number in range(ROUNDS):
        settings = PairSettings(scene).between(group, everyone)
        keep = settings.collides & (times[group, None] == times[None, :])
        need = np.where(keep, (1.0 + ROOM) * settings.distance, 0.0)
        offset = places[group, None] - places[None]
        gap = np.hypot(offset[..., 0], offset[..., 1])
        near = keep & (gap < (1.0 + 0.5 * ROOM) * settings.distance)
        if not near.any() and rooms.hold(group, places):
            break
        if number >= WIDER and number % WIDER == 0:
            others = np.flatnonzero(near.any(axis=0) & free)
            group = np.union1d(group, others)
            continue
        lack = np.where(keep, np.maximum(need - gap, 0.0), 0.0)
        angle = TURN * everyone[group]
        aside = np.column_stack([np.cos(angle), np.sin(angle)])
        away = np.where(
            (gap > 0.0)[..., None],
            offset / np.where(gap > 0.0, gap, 1.0)[..., None],
            aside[:, None],
        )
        share = np.where(np.isin(everyone, group), 0.5, 1.0)
        places[group] += ((share * lack)[..., None] * away).sum(axis=1)
        rooms.put(group, places)
    else:
        raise SeedingError(f"{_names(scene, pairs)}: no room nearby to ease them apart")
    if not rooms.reached(group, starts, places):
        raise SeedingError(f"{_names(scene, pairs)}: a wall is in the way of easing them apart")
    return places


class _Rooms:
    """Where agents may be, by their radii."""

    def __init__(self, scene: Scene, space: FreeSpace | None) -> None:
        self._space = space
        self._radii = np.array(
            [agent.radius if agent.weights.wall > 0.0 else 0.0 for agent in scene.agents]
        )
        self._rooms: dict[float, shapely.Geometry] = {}

    def hold(self, group: IntArray, places: FloatArray) -> bool:
        """Whether a group stands clear of the walls."""
        if self._space is None:
            return True
        clearance = self._space.clearance(places[group])
        return bool((clearance > self._radii[group])[self._radii[group] > 0.0].all())

    def put(self, group: IntArray, places: FloatArray) -> None:
        """Move those of a group who are too near to a wall to the nearest place that is clear."""
        if self._space is None:
            return
        from stplan.world import nearest_in

        clearance = self._space.clearance(places[group])
        for a, gap in zip(group.tolist(), clearance.tolist(), strict=True):
            radius = float(self._radii[a])
            if radius == 0.0 or gap > radius * (1.0 + 0.5 * ROOM):
                continue
            room = self._room(radius)
            if not room.is_empty:
                places[a] = nearest_in(room, places[a])

    def reached(self, group: IntArray, starts: FloatArray, places: FloatArray) -> bool:
        """Whether the straight ways of a group are clear of the walls."""
        if self._space is None:
            return True
        moved = group[(starts[group] != places[group]).any(axis=1) & (self._radii[group] > 0.0)]
        clearance = self._space.segment_clearance(starts[moved], places[moved])
        return bool((clearance > self._radii[moved]).all())

    def _room(self, radius: float) -> shapely.Geometry:
        from stplan.world import eroded

        if radius not in self._rooms and self._space is not None:
            self._rooms[radius] = eroded(self._space.polygon, (1.0 + ROOM) * radius)
        return self._rooms[radius]


def _names(scene: Scene, pairs: IntArray) -> str:
    return ", ".join(scene.agents[a].id for a in np.unique(pairs).tolist())
