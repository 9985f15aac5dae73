"""Ways between the points that robots are sent to, cut into what is gone in a step of a grid of times."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stplan.arrays import FloatArray, Point
from stplan.replanning.ground import Distances, Ground
from stplan.scene.model import Agent
from stplan.seeding.search.shortest_ways import WayFinder
from stplan.world import FreeSpace

# The greatest speed is kept with this much to spare, against rounding.
SPARE = 1.0 - 1e-7
# So many ways besides the shortest one, of at most so many times its length and so many radii more.
DETOURS = 4
LONGER, LONGER_RADII = 1.6, 24.0
# Who stands in the way is passed at so many times the distance to be kept.
PASSING = 1.04
# Ways around somebody are drawn in steps of this share of that.
FINE = 0.05
# Where corners cannot be cut a step ends at one of so many points.
PIECES = 8
# The direction of a way is that over so many of them before and after.
SOME = 4
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
        self._distances: dict[tuple[float, Point], Distances] = {}

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

    def around(
        self, agent: Agent, way: FloatArray, bodies: FloatArray, apart: FloatArray
    ) -> Iterator[FloatArray]:
        """A way (n + 1, 2) led around `bodies` (B, 2) that stand on it, as walls allow."""
        kept = PASSING * apart
        met = np.hypot(*np.moveaxis(way[:, None] - bodies[None], -1, 0)).min(axis=0) <= kept
        met &= np.minimum(
            np.hypot(*(bodies - way[0]).T), np.hypot(*(bodies - way[-1]).T)
        ) > apart  # fmt: skip
        if len(way) < 3 or not met.any():
            return
        ground = self._ground(agent.radius)
        for first in (1.0, -1.0):
            led = way
            for body, reach in zip(bodies[met], kept[met], strict=True):
                for side in (first, -first):
                    trial = _led_around(led, body, float(reach), side)
                    if ground.sees(trial[:-1], trial[1:]).all():
                        led = trial
                        break
            found = self._cut(agent.radius, agent.max_speed or 1.0, led)
            if found is not None:
                yield found

    def steps(self, agent: Agent, start: FloatArray, goal: Point) -> float:
        """How many steps the shortest way takes; inf where there is none."""
        return next((float(len(way) - 1) for way in self.ways(agent, start, goal)), np.inf)

    def _way(self, radius: float, speed: float, stops: FloatArray) -> FloatArray | None:
        """The shortest way over `stops` (n, 2), cut into steps."""
        if (stops == stops[0]).all():
            return stops[:1]
        found = self._finder.way(stops, radius)
        return None if found is None else self._cut(radius, speed, found.points)

    def _cut(self, radius: float, speed: float, way: FloatArray) -> FloatArray | None:
        """A way (m, 2) cut into steps; None where it touches a wall."""
        pace = SPARE * speed * self._step
        points = evenly(way, pace)
        ground = self._ground(radius)
        if not ground.sees(points[:-1], points[1:]).all():
            # Corners that are cut would touch a wall: steps there are as long as walls let them be.
            points = _as_far_as_seen(ground, evenly(way, pace / PIECES))
        return points if ground.sees(points[:-1], points[1:]).all() else None

    def _detours(
        self, radius: float, speed: float, start: Point, goal: Point, direct: FloatArray
    ) -> list[FloatArray]:
        """Ways by spots beside those known, the shortest first."""
        ground = self._ground(radius)
        back, on = self._to(radius, start), self._to(radius, goal)
        total = back.of_spots + on.of_spots
        longest = LONGER * speed * self._step * (len(direct) - 1) + LONGER_RADII * radius
        offered = np.flatnonzero(total <= longest)
        offered = offered[np.argsort(total[offered], kind="stable")]
        away = np.full(len(offered), np.inf)
        found: list[FloatArray] = []
        way: FloatArray | None = direct
        while len(found) < DETOURS:
            if way is not None:
                # Points of a way are nearer to each other than ways are apart.
                some = way[:: max(int(ASIDE * radius / (2.0 * speed * self._step)), 1)]
                gaps = ground.spots[offered, None] - some[None]
                away = np.minimum(away, np.hypot(gaps[..., 0], gaps[..., 1]).min(axis=1))
            left = np.flatnonzero(away > ASIDE * radius)
            if not len(left):
                break
            via = int(offered[left[0]])
            away[left[0]] = 0.0
            whole = np.vstack([back.way_from(via)[::-1], on.way_from(via)[1:]])
            way = self._cut(radius, speed, whole)
            if way is not None:
                found.append(way)
        return sorted(found, key=len)

    def _to(self, radius: float, point: Point) -> Distances:
        """Ways from the spots of a ground to a point."""
        key = (radius, point)
        if key not in self._distances:
            self._distances[key] = self._ground(radius).distances_to(np.array(point))
        return self._distances[key]

    def _ground(self, radius: float) -> Ground:
        if radius not in self._grounds:
            self._grounds[radius] = Ground.of(self._space, radius)
        return self._grounds[radius]


def _as_far_as_seen(ground: Ground, way: FloatArray) -> FloatArray:
    """Points (n, 2) of a `way` (m, 2), each the furthest of the next few that is seen from the one before."""
    kept = [0]
    while kept[-1] < len(way) - 1:
        here = kept[-1]
        ahead = way[here + 1 : here + 1 + PIECES]
        seen = np.flatnonzero(ground.sees(np.broadcast_to(way[here], ahead.shape), ahead))
        kept.append(here + 1 + (int(seen[-1]) if len(seen) else 0))
    return way[kept]


def _led_around(way: FloatArray, body: FloatArray, reach: float, side: float) -> FloatArray:
    """A way (n, 2), its points beside a body moved out of reach (m) to one side of it."""
    way = evenly(way, FINE * reach)
    offsets = way - body
    nearest = int((offsets**2).sum(axis=1).argmin())
    ahead = way[min(nearest + SOME, len(way) - 1)] - way[max(nearest - SOME, 0)]
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-300)
    aside = side * np.array([-ahead[1], ahead[0]])
    along = offsets @ ahead
    beside = (np.abs(along) < reach) & ((offsets**2).sum(axis=1) < (2.0 * reach) ** 2)
    beside &= offsets @ aside < np.sqrt(np.maximum(reach**2 - along**2, 0.0))
    beside[[0, -1]] = False
    out = np.sqrt(np.maximum(reach**2 - along**2, 0.0))
    moved = body + along[:, None] * ahead + out[:, None] * aside
    return np.where(beside[:, None], moved, way)


def evenly(way: FloatArray, longest: float) -> FloatArray:
    """(n + 1, 2) points along a way (m, 2), evenly spaced by no more than `longest` (m), both ends exact."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    count = max(int(np.ceil(along[-1] / longest * (1.0 - 1e-12))), 1)
    at = np.linspace(0.0, along[-1], count + 1)
    points = np.column_stack([np.interp(at, along, way[:, x]) for x in range(2)])
    points[0], points[-1] = way[0], way[-1]
    return points
