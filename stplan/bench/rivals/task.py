"""What a rival makes of a scene, and the problem it is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.scene.model import Scene
from stplan.world import FreeSpace


@dataclass(frozen=True)
class Task:
    """A scene whose agents are all equally fast.

    Attributes:
        scene, free_space: what is planned, None in the open plane.
        speed, acceleration: limits of every agent, m/s and m/s^2. Few rivals know the second.
        ways: (n, 2) a polyline an agent, the shortest way for it alone.
        curves: (n, 3) initial curves an agent, clear of each other, for whoever can start from them.
        time_limit: how long a rival may take, s.
    """

    scene: Scene
    free_space: FreeSpace | None
    speed: float
    acceleration: float
    ways: list[FloatArray]
    curves: list[FloatArray]
    time_limit: float

    @property
    def starts(self) -> FloatArray:
        """(A, 2) m."""
        return np.array([agent.start for agent in self.scene.agents])

    @property
    def goals(self) -> FloatArray:
        """(A, 2) m."""
        return np.array([agent.goal for agent in self.scene.agents])

    @property
    def radii(self) -> FloatArray:
        """(A,) m."""
        return np.array([agent.radius for agent in self.scene.agents])

    def pace(self, agent: int) -> float:
        """The speed (m/s) that somebody would like: the greatest, or what its preferred arrival asks for."""
        own = self.scene.agents[agent]
        if own.preferred_time is None:
            return self.speed
        length = float(np.hypot(*np.diff(self.ways[agent], axis=0).T).sum())
        return min(self.speed, length / (own.preferred_time - own.start_time))


@dataclass(frozen=True)
class Motion:
    """Curves (n, 3) an agent as x, y, t and who reached its goal; no curves where there is no plan.

    `rests` says that agents start and end at rest, so that getting going and stopping count too.
    """

    curves: list[FloatArray]
    arrived: BoolArray
    note: str = ""
    rests: bool = False


def no_motion(count: int, note: str) -> Motion:
    """The outcome of a rival that found nothing."""
    return Motion([], np.zeros(count, dtype=bool), note)


def next_stop(way: FloatArray, reached: int, place: FloatArray, near: float) -> int:
    """The index of the corner of `way` to head for, given the last one headed for."""
    while reached < len(way) - 1 and np.hypot(*(way[reached] - place)) < near:
        reached += 1
    return reached
