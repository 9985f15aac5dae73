"""The worlds that a scene with changes goes through, and everybody who ever was in one of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray
from stplan.scene.model import Agent, Scene

if TYPE_CHECKING:
    from stplan.world import FreeSpace


@dataclass(frozen=True)
class World:
    """What holds from `begin` to `end`, s.

    Attributes:
        scene: with everybody's own start in it.
        removed: ids of agents that are gone.
    """

    scene: Scene
    begin: float
    end: float
    removed: frozenset[str] = frozenset()

    @property
    def agents(self) -> dict[str, Agent]:
        """Those who are there or still to come, by id."""
        return {one.id: one for one in self.scene.agents if one.id not in self.removed}


def worlds_of(scene: Scene) -> list[World]:
    """The world as it is first, and after every change."""
    begins = [-np.inf, *(change.at for change in scene.changes)]
    ends = [*begins[1:], np.inf]
    scenes = [(scene, frozenset[str]())]
    scenes += [(change.scene, change.removed) for change in scene.changes]
    return [
        World(one, begin, end, removed)
        for (one, removed), begin, end in zip(scenes, begins, ends, strict=True)
    ]


def space_of(scene: Scene) -> FreeSpace | None:
    """The free space of a scene that has no changes, None in the open plane: then no map room is loaded.

    Raises:
        SceneError: the map cannot be read, or nothing is left of it.
    """
    if scene.map is None:
        return None
    from stplan.world import build_free_space

    return build_free_space(scene)


def spaces_of(scene: Scene) -> list[FreeSpace | None]:
    """The free space of every world of a scene. Worlds of one map share theirs. Raises likewise."""
    known: list[tuple[Scene, FreeSpace | None]] = []
    spaces = []
    for world in worlds_of(scene):
        now = world.scene
        found = next((one for one in known if _same_floor(one[0], now)), None)
        if found is None:
            found = now, space_of(now)
            known.append(found)
        spaces.append(found[1])
    return spaces


def _same_floor(one: Scene, other: Scene) -> bool:
    """Whether the free space of both is the same, as far as their maps and smallest radii tell."""
    if one.map is None or other.map is None:
        return one.map is other.map
    least, least_other = (min(agent.radius for agent in each.agents) for each in (one, other))
    return one.map == other.map and least == least_other


def whole_scene(scene: Scene, curves: Mapping[str, FloatArray]) -> Scene:
    """A scene of everybody who ever was there, whose ends are those of their `curves`: to be looked at."""
    worlds = worlds_of(scene)
    last = worlds[-1]
    agents, seen = [], set()
    for world in reversed(worlds):
        for name, agent in world.agents.items():
            if name not in seen and name in curves:
                seen.add(name)
                agents.append(_as_executed(agent, curves[name], gone=name in last.removed))
    order = {name: k for k, name in enumerate(curves)}
    agents.sort(key=lambda agent: order[agent.id])
    place = {agent.id: k for k, agent in enumerate(agents)}
    names = [agent.id for agent in last.scene.agents]
    rules = tuple(
        replace(
            rule,
            left=tuple(place[names[a]] for a in rule.left if names[a] in place),
            right=tuple(place[names[a]] for a in rule.right if names[a] in place),
        )
        for rule in last.scene.pairs
    )
    return replace(
        scene, agents=tuple(agents), pairs=rules, map=last.scene.map, assignments=(), agent_paths=(),
        horizon=last.scene.horizon,
    )  # fmt: skip


def _as_executed(agent: Agent, curve: FloatArray, *, gone: bool) -> Agent:
    (x, y, t), (u, v, end) = curve[0].tolist(), curve[-1].tolist()
    return replace(
        agent, start=(x, y), goal=(u, v), start_time=t, max_time=max(agent.max_time, end),
        after_arrival="vanish" if gone else agent.after_arrival,
        path=None if gone else agent.path,
    )  # fmt: skip
