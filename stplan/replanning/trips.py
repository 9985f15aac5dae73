"""Ways between the points that robots are sent to, cut into what is gone in a step of a grid of times."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stplan.arrays import FloatArray, Point
from stplan.replanning.ground import Ground
from stplan.scene.model import Agent
from stplan.seeding.search.shortest_ways import WayFinder
from stplan.world import FreeSpace

# The greatest speed is kept with this much to spare, against rounding.
SPARE = 1.0 - 1e-7
# So many ways besides the shortest one, of at most so many times its length and so many radii more.
DETOURS = 4
LONGER, LONGER_RADII = 1.6, 24.0
# Each leads by a spot that is so many radii off all before.
ASIDE = 5.0


class Trips:
    """Ways in one free space, each worked out once.

    Args:
        step: of the grid of times, s.
    """

    def __init__(self, space: FreeSpace, step: float) -> None:
        self._space, self._step = space, step
        self._finder = WayFinder(space)
        self._grounds: dict[float, Ground] = {}
        self._known: dict[tuple[float, float, Point, Point], list[FloatArray]] = {}
        self._lengths: dict[tuple[float, Point], FloatArray] = {}

    def ways(self, agent: Agent, start: FloatArray, goal: Point) -> Iterator[FloatArray]:
        """(n + 1, 2) points of ways, one for every step at the agent's speed: the shortest first.

        None at all where there is no way.
        """
        speed = agent.max_speed or 1.0
        begin: Point = (float(start[0]), float(start[1]))
        key = (agent.radius, speed, begin, goal)
        if key not in self._known:
            direct = self._way(agent.radius, speed, np.array([begin, goal]))
            self._known[key] = [] if direct is None else [direct]
        known = self._known[key]
        yield from known
        if len(known) == 1:
            known += self._detours(agent.radius, speed, begin, goal, known[0])
            yield from known[1:]

    def steps(self, agent: Agent, start: FloatArray, goal: Point) -> float:
        """How many steps the shortest way takes; inf where there is none."""
        return next((float(len(way) - 1) for way in self.ways(agent, start, goal)), np.inf)

    def _way(self, radius: float, speed: float, stops: FloatArray) -> FloatArray | None:
        """The shortest way over `stops` (n, 2), cut into steps."""
        if (stops == stops[0]).all():
            return stops[:1]
        found = self._finder.way(stops, radius)
        if found is None:
            return None
        pace = SPARE * speed * self._step
        points = evenly(found.points, pace)
        ground = self._ground(radius)
        if not ground.sees(points[:-1], points[1:]).all():
            # Corners that are cut would touch a wall.
            pieces = [
                evenly(found.points[k : k + 2], pace)[1:] for k in range(len(found.points) - 1)
            ]
            points = np.vstack([found.points[:1], *pieces])
        return points if ground.sees(points[:-1], points[1:]).all() else None

    def _detours(
        self, radius: float, speed: float, start: Point, goal: Point, direct: FloatArray
    ) -> list[FloatArray]:
        """Ways by spots beside those known, the shortest first."""
        ground = self._ground(radius)
        total = self._of_spots(radius, start) + self._of_spots(radius, goal)
        longest = LONGER * speed * self._step * (len(direct) - 1) + LONGER_RADII * radius
        offered = np.flatnonzero(total <= longest)
        offered = offered[np.argsort(total[offered], kind="stable")]
        away = np.full(len(offered), np.inf)
        found: list[FloatArray] = []
        way: FloatArray | None = direct
        while len(found) < DETOURS:
            if way is not None:
                for point in way:
                    away = np.minimum(away, np.hypot(*(ground.spots[offered] - point).T))
            left = np.flatnonzero(away > ASIDE * radius)
            if not len(left):
                break
            via = ground.spots[offered[left[0]]]
            away[left[0]] = 0.0
            way = self._way(radius, speed, np.array([start, via, goal]))
            if way is not None:
                found.append(way)
        return sorted(found, key=len)

    def _of_spots(self, radius: float, point: Point) -> FloatArray:
        """(N,) lengths of ways from the spots of a ground to a point, m."""
        key = (radius, point)
        if key not in self._lengths:
            ground = self._ground(radius)
            self._lengths[key] = ground.distances_to(np.array(point)).of_spots
        return self._lengths[key]

    def _ground(self, radius: float) -> Ground:
        if radius not in self._grounds:
            self._grounds[radius] = Ground.of(self._space, radius)
        return self._grounds[radius]


def evenly(way: FloatArray, longest: float) -> FloatArray:
    """(n + 1, 2) points along a way (m, 2), evenly spaced by no more than `longest` (m), both ends exact."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    count = max(int(np.ceil(along[-1] / longest * (1.0 - 1e-12))), 1)
    at = np.linspace(0.0, along[-1], count + 1)
    points = np.column_stack([np.interp(at, along, way[:, x]) for x in range(2)])
    points[0], points[-1] = way[0], way[-1]
    return points
