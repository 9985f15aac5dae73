"""Families of scenes that grow with the number of agents, built in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.kinetic_cost import least_kinetic_cost
from stplan.scene.model import Agent, Scene, SeedingSettings, SolverSettings, Weights


def agent(name: str, start: Sequence[float], goal: Sequence[float], **changes: object) -> Agent:
    """An agent of radius 0.5 m that has 20 s, but for `changes`."""
    plain = Agent(
        id=name,
        start=(float(start[0]), float(start[1])),
        goal=(float(goal[0]), float(goal[1])),
        start_time=0.0,
        max_time=20.0,
        preferred_time=None,
        radius=0.5,
        mass=1.0,
        after_arrival="stay",
        waypoints=(),
        weights=Weights(),
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


def scene(agents: Sequence[Agent], **changes: object) -> Scene:
    """A scene of `agents` in the open plane, its horizon the latest `max_time`."""
    plain = Scene(
        name="family",
        description="",
        source=None,
        content_hash="",
        map=None,
        horizon=max(one.max_time for one in agents),
        time_scale=1.0,
        agents=tuple(agents),
        pairs=(),
        seeding=SeedingSettings(),
        solver=SolverSettings(),
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


def crowd(starts: FloatArray, goals: FloatArray, duration: float, **changes: object) -> Scene:
    """Agents from every row of `starts` (A, 2) to that of `goals` within `duration` s."""
    return scene(
        [
            agent(f"a{k}", start, goal, max_time=duration, **changes)
            for k, (start, goal) in enumerate(zip(starts, goals, strict=True))
        ]
    )


class _Places:
    """Points that keep apart from each other, found through a grid of which a cell holds one at most."""

    def __init__(self, apart: float) -> None:
        self._apart, self._cell = apart, apart / np.sqrt(2.0)
        self._points: dict[tuple[int, int], FloatArray] = {}

    def take(self, point: FloatArray) -> bool:
        """Keep a point if it is more than `apart` m from all others; whether it was kept."""
        column, row = (int(x) for x in np.floor(point / self._cell))
        near = [
            found
            for i in range(column - 2, column + 3)
            for j in range(row - 2, row + 3)
            if (found := self._points.get((i, j))) is not None
        ]
        if near and np.hypot(*(np.array(near) - point).T).min() <= self._apart:
            return False
        self._points[column, row] = point
        return True


def scattered(
    rng: np.random.Generator, count: int, low: FloatArray, high: FloatArray, apart: float
) -> FloatArray:
    """`count` random points in a box, pairwise more than `apart` m from one another."""
    places, points = _Places(apart), list[FloatArray]()
    while len(points) < count:
        point = rng.uniform(low, high)
        if places.take(point):
            points.append(point)
    return np.array(points).reshape(-1, 2)


def _side(count: int, radius: float, density: float) -> float:
    """Of a square that `count` discs fill to `density`, m."""
    return float(np.sqrt(count * np.pi * radius**2 / density))


def open_field(count: int, density: float, rng_seed: int = 0, radius: float = 0.5) -> Scene:
    """Random starts and goals in a square that discs fill to `density`; 1 m/s would cross it."""
    rng = np.random.default_rng(rng_seed)
    side = _side(count, radius, density)
    box = np.zeros(2), np.full(2, side)
    starts = scattered(rng, count, *box, 2.2 * radius)
    goals = scattered(rng, count, *box, 2.2 * radius)
    return crowd(starts, goals, side, radius=radius)


def wide_field(
    count: int,
    density: float = 0.06,
    rng_seed: int = 0,
    radius: float = 0.5,
    longest: float = 60.0,
) -> Scene:
    """The same with ways of at most `longest` m, 1 m/s for the longest."""
    rng = np.random.default_rng(rng_seed)
    side = _side(count, radius, density)
    starts = scattered(rng, count, np.zeros(2), np.full(2, side), 2.2 * radius)
    places, goals = _Places(2.2 * radius), list[FloatArray]()
    while len(goals) < count:
        angle, length = rng.uniform(0.0, 2.0 * np.pi), longest * np.sqrt(rng.uniform())
        goal = starts[len(goals)] + length * np.array([np.cos(angle), np.sin(angle)])
        if (goal >= 0.0).all() and (goal <= side).all() and places.take(goal):
            goals.append(goal)
    return crowd(starts, np.array(goals), longest, radius=radius)


def crossing_flows(
    count: int,
    speed: float = 1.0,
    rng_seed: int = 0,
    radius: float = 0.5,
    density: float = 0.12,
) -> Scene:
    """Half of the agents walk east, half north, through a square that each fills half."""
    rng = np.random.default_rng(rng_seed)
    side = _side(count, radius, density)
    half = count // 2
    apart = 2.2 * radius
    west = scattered(rng, half, np.array([-side / 2, 0.0]), np.array([0.0, side]), apart)
    south = scattered(rng, count - half, np.array([0.0, -side / 2]), np.array([side, 0.0]), apart)
    # A little off the square, and as far beyond it, so that no two ends of the flows touch.
    starts = np.vstack([west - [apart, 0.0], south - [0.0, apart]])
    ways = (1.5 * side + 2.0 * apart) * np.eye(2)
    goals = starts + np.repeat(ways, [half, count - half], axis=0)
    return crowd(starts, goals, float(ways[0, 0]) / speed, radius=radius)


def circle(count: int, extent: float, duration: float, radius: float = 0.5) -> Scene:
    """Agents on a circle of radius `extent`, each going to the opposite point."""
    angle = 2.0 * np.pi * np.arange(count) / count
    starts = extent * np.column_stack([np.cos(angle), np.sin(angle)])
    return crowd(starts, -starts, duration, radius=radius)


def lanes(count: int, duration: float = 60.0, radius: float = 0.5) -> Scene:
    """Two columns of agents meet head-on, `count` in all, each to the other's mirror place."""
    rows = count // 2
    y = 3.0 * radius * np.arange(rows)
    starts = np.vstack([np.column_stack([np.full(rows, x), y]) for x in (0.0, 50.0)])
    goals = np.vstack([starts[rows:], starts[:rows]])
    return crowd(starts, goals, duration, radius=radius)


def heavy_lanes(rng: np.random.Generator, count: int, heavy: int = 2) -> Scene:
    """`lanes` in which `heavy` random agents weigh 20 to 100 times as much as the others."""
    plain = lanes(count, duration=float(rng.uniform(50.0, 70.0)))
    chosen = set(rng.permutation(count)[:heavy].tolist())
    return replace(
        plain,
        agents=tuple(
            replace(one, mass=float(rng.uniform(20.0, 100.0))) if index in chosen else one
            for index, one in enumerate(plain.agents)
        ),
    )


def straight_kinetic_cost(scene: Scene) -> float:
    """Kinetic cost of walking straight at constant speed, J s."""
    return sum(
        least_kinetic_cost(one.mass, np.array([one.start, one.goal]), one.max_time - one.start_time)
        for one in scene.agents
    )
