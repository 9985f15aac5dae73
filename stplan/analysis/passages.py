"""How wide the widest way of every agent is at its narrowest, where that is, and whether it fits.

The free space is eroded by growing distances until an agent's start, waypoints and goal no longer
lie in one part of what is left; the gap that then closes is the narrowest place of its widest way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.model import Scene
from stplan.world import FreeSpace, eroded

# The half-widths looked at are multiples of this share of half the map's extent: 2 to the power -16.
FINENESS = 16
# Half-widths beyond so many radii are no narrow places.
WIDE = 4.0
# Narrow places whose widths and positions differ less than this share of a radius are the same.
SAME = 0.1


@dataclass(frozen=True)
class Passage:
    """A narrowest place of the widest ways of some agents.

    Attributes:
        agents: who has to pass it, the largest first.
        half_width: distance to the walls in its middle, m.
        radius: of the largest of them, m.
        place: where it is, m.
        stop: whether it is a start, goal or waypoint of theirs, near a wall.
        blocked: those that do not fit through.
        side_by_side: whether the two largest fit through at the same time.
    """

    agents: tuple[str, ...]
    half_width: float
    radius: float
    place: tuple[float, float]
    stop: bool
    blocked: tuple[str, ...]
    side_by_side: bool


def passages(problem: PlanningProblem) -> list[Passage] | None:
    """Narrow places, the tightest for the radii that have to pass them first; None without walls."""
    scene = problem.scene
    heeding = np.flatnonzero(problem.heeds_walls & ~problem.prescribed).tolist()
    if problem.free_space is None or not heeding:
        return None
    erosions = _Erosions(problem.free_space)
    found: dict[tuple[int, int, int], list[int]] = {}
    spots = {}
    for a in heeding:
        width, place, stop = erosions.narrowest(_stops(problem, a))
        radius = scene.agents[a].radius
        if width >= WIDE * radius:
            continue
        grain = SAME * min(agent.radius for agent in scene.agents)
        key = (round(width / grain), round(place[0] / grain), round(place[1] / grain))
        found.setdefault(key, []).append(a)
        spots[key] = (width, place, stop)
    facts = [_passage(scene, agents, *spots[key]) for key, agents in found.items()]
    return sorted(facts, key=lambda fact: fact.half_width / fact.radius)


def _stops(problem: PlanningProblem, a: int) -> FloatArray:
    return np.vstack([problem.starts[a], problem.waypoints[a], problem.goals[a]])


def _passage(
    scene: Scene, agents: Sequence[int], width: float, place: tuple[float, float], stop: bool
) -> Passage:
    by_size = sorted(agents, key=lambda a: -scene.agents[a].radius)
    radii = [scene.agents[a].radius for a in by_size]
    return Passage(
        tuple(scene.agents[a].id for a in by_size),
        width, radii[0], place, stop,
        tuple(scene.agents[a].id for a in by_size if scene.agents[a].radius >= width),
        side_by_side=len(radii) > 1 and 2 * width > 2 * (radii[0] + radii[1]),
    )  # fmt: skip


class _Erosions:
    """The parts of the free space further than some distance from the walls, each made once."""

    def __init__(self, free_space: FreeSpace) -> None:
        self._space = free_space
        x0, y0, x1, y1 = free_space.polygon.bounds
        self._reach = min(x1 - x0, y1 - y0) / 2
        self._parts: dict[float, shapely.STRtree] = {}

    def parts(self, distance: float) -> shapely.STRtree:
        """The parts at `distance` (m) from the walls."""
        if distance not in self._parts:
            shape = eroded(self._space.polygon, distance, quad_segs=16)
            self._parts[distance] = shapely.STRtree(shapely.get_parts(shape))
        return self._parts[distance]

    def narrowest(self, stops: FloatArray) -> tuple[float, tuple[float, float], bool]:
        """Half-width (m) of the narrowest place of the widest way over `stops`; its place; if a stop."""
        own = self._space.clearance(stops)
        first = int(own.argmin())
        at_stop = (float(own[first]), (float(stops[first, 0]), float(stops[first, 1])), True)
        # Multiples of one length, so that agents share erosions.
        low, high = 0, 2**FINENESS
        unit = self._reach / high
        if self._connected(unit * np.floor(own[first] / unit), stops):
            return at_stop
        while high - low > 1:
            middle = (low + high) // 2
            if self._connected(unit * middle, stops):
                low = middle
            else:
                high = middle
        return unit * low, self._gap(unit * low, unit * high, stops), False

    def _connected(self, distance: float, stops: FloatArray) -> bool:
        return len(self._common(distance, stops)) > 0

    def _common(self, distance: float, stops: FloatArray) -> set[int]:
        """The parts that hold all `stops`."""
        tree = self.parts(distance)
        stop, part = tree.query(shapely.points(stops), predicate="intersects")
        sets = [set(part[stop == k].tolist()) for k in range(len(stops))]
        return set.intersection(*sets)

    def _gap(self, open_at: float, closed_at: float, stops: FloatArray) -> tuple[float, float]:
        """Where the way over `stops` closes when the distance to the walls grows."""
        parts = self.parts(closed_at).geometries
        if len(parts):
            # Every stop has its part, the nearest, and the way closes between two of these.
            near = [int(shapely.distance(parts, shapely.Point(stop)).argmin()) for stop in stops]
            for a, b in pairwise(near):
                if a != b:
                    middle = shapely.shortest_line(parts[a], parts[b]).centroid
                    return float(middle.x), float(middle.y)
        # It is as narrow everywhere; any place of it will do.
        whole = self.parts(open_at).geometries[min(self._common(open_at, stops))]
        spot = shapely.shortest_line(whole, shapely.Point(stops.mean(axis=0))).coords[0]
        return float(spot[0]), float(spot[1])
