"""Coordinates in which plans are made: near the origin, agents of ordinary size and speed.

Whoever writes a scene chooses where its origin lies, which way the axes point and what lengths, times and
masses are measured in. A plan should not depend on it. So every scene is planned in a frame of its own:

- the origin is where the longest trip starts, the clock begins with the first agent;
- the axes lie along the longest trip in the open, and else along or across most of the walls, as near to
  the longest trip as that is;
- the units of length and time are such that the median radius is the default one and the median speed that of
  a stroll, so that all tolerances mean what they mean to people; the unit of mass is the geometric mean.

A scene that is moved, turned or written in other units then gives the same local problem. Rounding would
spoil that: decimals that are moved far from the origin lose digits, and every product adds an error. So
differences are rounded to as many decimals as their terms were worth (15 digits), and local coordinates to
2^-40. Where a copy cannot be told from a scene of other numbers, it still differs: after a turn far from the
origin coordinates are off by their own rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.arrivals import free_arrival
from stplan.scene.model import Agent, Scene

if TYPE_CHECKING:
    from stplan.world.free_space import FreeSpace

# The median radius (the default one) and the median speed in local units.
TYPICAL_RADIUS, TYPICAL_SPEED = 0.3, 0.6
# Local coordinates and times are multiples of this; other quantities have so many digits.
GRID = 2.0**-40
# Decimal digits that any double keeps.
DIGITS = 15
# Trips and angles (rad) that differ by less than this share count as equal.
EQUAL = 1e-6
# Directions of walls (rad) this near to each other are one.
PARALLEL = 1e-5
# Corners this far off the line through their neighbours are none: units of the grid, and of the scene's
# own rounding.
STRAIGHT_GRIDS, STRAIGHT_ROUNDINGS = 16.0, 8.0


@dataclass(frozen=True)
class PlanningFrame:
    """A local frame: x_local = R (x - origin) / length, t_local = (t - start) / time.

    Attributes:
        origin: in m.
        start: in s.
        cosine, sine: R = [[cosine, sine], [-sine, cosine]].
        length, time, mass: the local units in m, s and kg.
    """

    origin: tuple[float, float] = (0.0, 0.0)
    start: float = 0.0
    cosine: float = 1.0
    sine: float = 0.0
    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    @staticmethod
    def of_scene(scene: Scene, free_space: FreeSpace | None) -> PlanningFrame:
        """The frame that `scene` is planned in."""
        stops = [_stops(agent) for agent in scene.agents]
        ways = np.array([float(np.hypot(*np.diff(own, axis=0).T).sum()) for own in stops])
        # How long agents would like to take: a horizon that nobody has a use for changes nothing.
        spans = np.array([free_arrival(agent) - agent.start_time for agent in scene.agents])
        trip = stops[int(np.flatnonzero(ways >= (1.0 - EQUAL) * ways.max())[0])]
        aside = _difference(trip, trip[0])
        furthest = aside[int(np.hypot(*aside.T).argmax())]
        angle = float(np.arctan2(furthest[1], furthest[0]))
        if free_space is not None:
            angle += _turn_to_walls(free_space.boundary_segments, angle)
        cosine, sine = (
            0.0 if abs(part) < GRID else part
            for part in (float(np.cos(angle)), float(np.sin(angle)))
        )
        length = float(np.median([agent.radius for agent in scene.agents])) / TYPICAL_RADIUS
        speed = float(np.median(ways / spans)) or float(np.mean(ways / spans))
        return PlanningFrame(
            origin=(float(trip[0, 0]), float(trip[0, 1])),
            start=min(agent.start_time for agent in scene.agents),
            cosine=cosine,
            sine=sine,
            length=length,
            time=TYPICAL_SPEED * length / speed if speed > 0.0 else float(np.median(spans)),
            mass=float(np.exp(np.mean(np.log([agent.mass for agent in scene.agents])))),
        )

    @property
    def speed(self) -> float:
        """The local unit in m/s."""
        return self.length / self.time

    @property
    def acceleration(self) -> float:
        """The local unit in m/s^2."""
        return self.speed / self.time

    @property
    def cost(self) -> float:
        """The local unit of costs, kg m^2/s = J s."""
        return self.mass * self.length * self.speed

    def local_points(self, points: FloatArray) -> FloatArray:
        """`points` (N, 2) of the scene in this frame."""
        x, y = _difference(points, np.array(self.origin)).T
        turned = np.column_stack([self.cosine * x + self.sine * y, self.cosine * y - self.sine * x])
        return _on_grid(turned / self.length)

    def local_times(self, times: FloatArray) -> FloatArray:
        """`times` (N,) of the scene in this frame."""
        return _on_grid(_difference(times, np.float64(self.start)) / self.time)

    def local_velocity(self, velocity: tuple[float, float]) -> tuple[float, float]:
        """`velocity` of the scene in this frame."""
        x, y = velocity
        turned = (self.cosine * x + self.sine * y, self.cosine * y - self.sine * x)
        return share(turned[0], self.speed), share(turned[1], self.speed)

    def points(self, local: FloatArray) -> FloatArray:
        """`local` points (N, 2) in m."""
        x, y = self.length * local.T
        turned = np.column_stack([self.cosine * x - self.sine * y, self.sine * x + self.cosine * y])
        return turned + self.origin

    def times(self, local: FloatArray) -> FloatArray:
        """`local` times (N,) in s."""
        return self.start + self.time * local

    def curve(self, local: FloatArray) -> FloatArray:
        """A `local` curve (n, 3) in m and s."""
        return np.column_stack([self.points(local[:, :2]), self.times(local[:, 2])])

    def local_space(self, space: FreeSpace) -> FreeSpace:
        """The free space in this frame; corners that only rounding makes are left out."""
        rounding = float(np.spacing(np.abs(space.boundary_vertices).max()))
        straight = max(STRAIGHT_GRIDS * GRID, STRAIGHT_ROUNDINGS * rounding / self.length)
        return space.moved(self.local_points, straight)


def share(value: float, unit: float) -> float:
    """`value` in `unit`, with as many digits as the grid has."""
    quotient = float(value / unit)
    if quotient == 0.0 or not math.isfinite(quotient):
        return quotient
    fraction, exponent = math.frexp(quotient)
    return math.ldexp(round(fraction / GRID) * GRID, exponent)


def _stops(agent: Agent) -> FloatArray:
    """(n, 2) start, waypoints and goal, or the corners of a prescribed path."""
    if agent.path is not None:
        return np.array(agent.path)[:, :2]
    return np.array([agent.start, *agent.waypoints, agent.goal], dtype=np.float64)


def _difference(values: FloatArray, base: FloatArray | np.float64) -> FloatArray:
    """`values` less `base`, to as many decimals as both were worth."""
    largest = np.maximum(np.maximum(np.abs(values), np.abs(base)), 1e-280)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(largest)))
    return np.asarray(np.round((values - base) * scale) / scale)


def _on_grid(values: FloatArray) -> FloatArray:
    """`values`, each the nearest multiple of the grid; without negative zeros."""
    return np.asarray(np.round(values / GRID) * GRID + 0.0)


def _turn_to_walls(segments: FloatArray, angle: float) -> float:
    """From `angle` (rad) to the nearest direction along or across most of the walls `segments` (E, 4).

    Walls that are parallel or at right angles count together, however they are cut into edges. Of directions
    that have as much of them the one nearest to `angle` is taken.
    """
    wall = (segments[:, 2] - segments[:, 0]) + 1j * (segments[:, 3] - segments[:, 1])
    length = np.abs(wall)
    wall, length = wall[length > 0.0], length[length > 0.0]
    quarter = 0.5 * np.pi
    # A trip half-way between two directions takes the same of them whatever rounding says.
    low = 0.5 * quarter + EQUAL
    turns = (np.angle(wall) - angle + low) % quarter - low
    order = np.argsort(turns)
    begins = np.flatnonzero(np.diff(turns[order], prepend=-np.inf) > PARALLEL)
    total = np.add.reduceat(length[order], begins)
    mean = np.add.reduceat((length * turns)[order], begins) / total
    most = mean[total >= (1.0 - EQUAL) * total.max()]
    return float(most[np.argmin(np.abs(most) + EQUAL * (most > 0.0))])
