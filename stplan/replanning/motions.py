"""Motions that an agent can choose from for a short while: each ends at rest, on a grid of times.

Velocities change by at most the acceleration times a step of the grid from one step to the next, and from
rest by half of that, so that the certificate finds no more. Whoever goes on with the motion it chose last
stops where that ends: from every state there is a way to stand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray

# Directions of the fan, and shares of the greatest speed.
DIRECTIONS = np.radians([0, 10, -10, 22, -22, 38, -38, 60, -60, 90, -90, 130, -130, 180])
SHARES = np.array([1.0, 0.7, 0.4, 0.15])
# Limits are kept with this much to spare, against rounding.
SPARE = 1.0 - 1e-7


@dataclass(frozen=True)
class Limits:
    """Of one agent: m/s, m/s^2 (inf without any), and the step of the grid in s."""

    speed: float
    acceleration: float
    step: float

    @property
    def change(self) -> float:
        """How much a velocity changes from one step to the next at most, m/s."""
        return SPARE * self.acceleration * self.step

    @property
    def stopping(self) -> int:
        """Steps from the greatest speed to rest."""
        return 0 if np.isinf(self.acceleration) else int(np.ceil(self.speed / self.change))


def fan(
    limits: Limits,
    velocity: FloatArray,
    towards: FloatArray,
    windows: tuple[int, ...],
    *,
    first: bool,
    shares: FloatArray = SHARES,
) -> FloatArray:
    """(C, L, 2) velocities of motions around the direction `towards` (2,), the first of them at rest soon.

    Args:
        velocity: (2,) of the step before, m/s.
        windows: for how many steps a velocity is aimed at, before the agent stops.
        first: whether this is its very first step.
        shares: of the greatest speed that are aimed at.
    """
    angle = float(np.arctan2(towards[1], towards[0]))
    angles = angle + DIRECTIONS
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    wanted = (SPARE * limits.speed * shares[:, None, None] * ways[None]).reshape(-1, 2)
    wanted = np.vstack([np.zeros(2), *[wanted] * len(windows)])
    length = np.concatenate([[0], np.repeat(windows, (len(wanted) - 1) // len(windows))])
    steps = max(windows) + limits.stopping + 1
    found = np.zeros((len(wanted), steps, 2))
    now = np.broadcast_to(velocity, wanted.shape)
    for k in range(steps):
        most = 0.5 * limits.change if first and k == 0 else limits.change
        change = np.where((k < length)[:, None], wanted, 0.0) - now
        size = np.hypot(change[:, 0], change[:, 1])[:, None]
        with np.errstate(invalid="ignore"):
            change = np.where(size > most, change * (most / np.maximum(size, 1e-300)), change)
        now = now + change
        found[:, k] = now
    return found


def arrivals(
    limits: Limits,
    place: FloatArray,
    velocity: FloatArray,
    goal: FloatArray,
    most: int,
    *,
    first: bool,
) -> list[FloatArray]:
    """Positions (n, 2) after every step of motions that come to rest on a `goal` (2,), the quickest first.

    They are cubic in time, those of at most so many steps that keep the limits.
    """
    found = []
    way = goal - place
    least = max(int(np.hypot(*way) / (limits.speed * limits.step)), 1)
    for n in range(least, most + 1):
        s = np.arange(1, n + 1)[:, None] / n
        points = place + (s - 2.0 * s**2 + s**3) * (n * limits.step) * velocity
        points = points + (3.0 * s**2 - 2.0 * s**3) * way
        points[-1] = goal
        moves = np.diff(np.vstack([place, points]), axis=0) / limits.step
        if np.hypot(*moves.T).max() > SPARE * limits.speed:
            continue
        change = np.hypot(*np.diff(np.vstack([velocity, moves, np.zeros(2)]), axis=0).T)
        change[0] *= 2.0 if first else 1.0
        if change.max() <= limits.change:
            found.append(points)
    return found
