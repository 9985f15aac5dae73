"""Every agent's shortest way around the walls, for its own radius, as if nobody else were there.

The free space is eroded by an agent's radius and a little more, arcs drawn as polygons around the true ones,
so that whatever lies in it is clear. In it shortest paths are exact. How much more is a question of what it
costs: of a ladder of margins the widest one is taken that makes no way longer than going round the same
corners a little further off would, so that narrow passages on shorter ways are not missed for wide detours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.deadline import heed
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.search.navigation_mesh import NavigationMesh, shortest_path, triangulated
from stplan.world.erosion import eroded
from stplan.world.free_space import FreeSpace

# Room beyond the radius, in radii: what is tried, the widest first. Passages with less slack than the
# narrow ones are looked for only where there is no way otherwise.
WIDE_MARGINS = (0.05, 0.02, 0.005, 1e-3)
NARROW_MARGIN = 1e-4
LAST_MARGINS = (1e-5, 1e-6, 1e-7)
# Pieces of a quarter of a circle: at least, and at most for so many corners of an eroded map in all.
FEWEST_PIECES = 16
MOST_CORNERS = 12_000
OUTER_PIECES = 4
# Ways of one class differ in length by the room times what they turn, here a bit more, and by this share.
TURNING_SHARE = 1.5
SAME_LENGTH = 2e-4
# A stop outside of the eroded space is tied to the nearest place inside, at most so many radii off.
LONGEST_TIE = 3.0
# What a way keeps over the radius, as a share of that: less is taken for touching.
LEAST_ROOM = 1e-9
# Seconds that an area takes to be triangulated, for every corner, and a way in it to be found: about half of
# what they are on a desktop.
TRIANGULATION_TIME, SEARCH_TIME = 8e-6, 4e-6


@dataclass(frozen=True)
class Way:
    """A shortest way.

    Attributes:
        legs: (n, 2) polylines from stop to stop, m.
        clearance: distance to the walls that it keeps, more than the radius, m.
    """

    legs: tuple[FloatArray, ...]
    clearance: float

    @cached_property
    def points(self) -> FloatArray:
        """(n, 2) all of it, m."""
        return np.vstack([self.legs[0], *(leg[1:] for leg in self.legs[1:])])

    @property
    def length(self) -> float:
        """Length in m."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def turning(self) -> float:
        """Sum of all turns, rad."""
        step = np.diff(self.points, axis=0)
        step = step[(step != 0.0).any(axis=1)]
        u, v = step[:-1], step[1:]
        cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        return float(np.abs(np.arctan2(cross, (u * v).sum(axis=1))).sum())


def shortest_ways(problem: PlanningProblem) -> list[Way | None]:
    """One an agent; None where there is none, for prescribed paths and for those who heed no walls."""
    space = problem.free_space
    found: list[Way | None] = [None] * problem.num_agents
    if space is None:
        return found
    finder = WayFinder(space)
    for agent, stops in enumerate(problem.stops):
        if len(stops) and problem.heeds_walls[agent]:
            found[agent] = finder.way(stops, float(problem.radii[agent]))
    return found


class WayFinder:
    """Finds shortest ways in one free space; each of its erosions is made once."""

    def __init__(self, space: FreeSpace) -> None:
        self._space = space
        self._areas: dict[tuple[float, float], _Area] = {}
        self._outer: dict[float, _Area] = {}

    def way(self, stops: FloatArray, radius: float) -> Way | None:
        """The shortest way over `stops` (n, 2) for a disc of `radius`, m; None where there is none."""
        straight = self._checked(tuple(np.stack(pair) for pair in pairwise(stops)), radius)
        if straight is not None and straight.clearance > (1.0 + WIDE_MARGINS[0]) * radius:
            return straight
        widest, least = self._at(stops, radius, WIDE_MARGINS[0]), self._least(stops, radius)
        if widest and least and not _detours(widest, least, WIDE_MARGINS[0] * radius):
            return widest
        narrow = self._at(stops, radius, NARROW_MARGIN)
        if narrow is None:
            ways = (self._at(stops, radius, margin) for margin in LAST_MARGINS)
            return next((way for way in ways if way is not None), straight)
        for margin in WIDE_MARGINS:
            wide = widest if margin == WIDE_MARGINS[0] else self._at(stops, radius, margin)
            if wide is not None and not _detours(wide, narrow, margin * radius):
                return wide
        return narrow

    def _at(self, stops: FloatArray, radius: float, margin: float) -> Way | None:
        """The shortest way with so much room."""
        heed()
        if (radius, margin) not in self._areas:
            polygon = _with_room(self._space, radius, margin)
            self._areas[radius, margin] = _Area(polygon, LONGEST_TIE * radius)
        legs = self._areas[radius, margin].legs(stops)
        return None if legs is None else self._checked(legs, radius)

    def _least(self, stops: FloatArray, radius: float) -> Way | None:
        """A way that no clear one is shorter than, though it may cut corners; None where none is known.

        It costs little in a map of many corners, where it saves looking for the narrow way.
        """
        heed()
        if radius not in self._outer:
            # With the ends of the arcs' chords on the arcs it is wider than the space it stands for.
            polygon = eroded(self._space.polygon, radius, quad_segs=OUTER_PIECES)
            self._outer[radius] = _Area(polygon, LONGEST_TIE * radius)
        area = self._outer[radius]
        legs = area.legs(stops) if area.holds(stops) else None
        return None if legs is None else Way(legs, 0.0)

    def _checked(self, legs: tuple[FloatArray, ...], radius: float) -> Way | None:
        """The way of these legs if it is clear."""
        clearance = min(
            float(self._space.segment_clearance(leg[:-1], leg[1:]).min()) for leg in legs
        )
        return Way(legs, clearance) if clearance > radius * (1.0 + LEAST_ROOM) else None


def _detours(wide: Way, narrow: Way, room: float) -> bool:
    """Whether a way with so much `room` (m) is longer than corners taken further off explain."""
    turning = max(wide.turning, narrow.turning)
    longer = wide.length - narrow.length
    return longer > TURNING_SHARE * room * turning + SAME_LENGTH * narrow.length


def _with_room(space: FreeSpace, radius: float, margin: float) -> shapely.Geometry:
    """The free space less a radius and a margin of it."""
    # Ends of the arcs' chords lie so much further off that their middles keep the margin.
    pieces = max(FEWEST_PIECES, math.ceil(math.pi / 4.0 / math.sqrt(margin)))
    while True:
        distance = radius * (1.0 + margin) / math.cos(math.pi / (4 * pieces))
        heed()
        polygon = eroded(space.polygon, distance, quad_segs=pieces)
        if pieces <= 1 or shapely.get_num_coordinates(polygon) <= MOST_CORNERS:
            return polygon
        pieces //= 2


class _Area:
    """A polygon as a mesh; stops outside of it are tied to the nearest place inside, so far off at most."""

    def __init__(self, polygon: shapely.Geometry, longest_tie: float) -> None:
        self._polygon, self._longest_tie = polygon, longest_tie
        shapely.prepare(polygon)

    @cached_property
    def _mesh(self) -> NavigationMesh:
        heed(TRIANGULATION_TIME * shapely.get_num_coordinates(self._polygon))
        return triangulated(self._polygon)

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(shapely.polygons(self._mesh.corners[self._mesh.triangles]))

    def holds(self, stops: FloatArray) -> bool:
        """Whether all of `stops` (n, 2) lie inside."""
        return bool(shapely.intersects_xy(self._polygon, stops[:, 0], stops[:, 1]).all())

    def legs(self, stops: FloatArray) -> tuple[FloatArray, ...] | None:
        """Shortest polylines between consecutive stops, None where there is none."""
        if self._polygon.is_empty or not len(self._mesh.triangles):
            return None
        tied = [self._inside(stop) for stop in stops]
        legs = []
        for (head, start), (tail, goal) in pairwise(zip(stops, tied, strict=True)):
            if start is None or goal is None:
                return None
            heed(SEARCH_TIME * len(self._mesh.triangles))
            leg = self._leg(start, goal)
            if leg is None:
                return None
            ends = [head[None], leg, tail[None]]
            legs.append(_without_repeats(np.vstack(ends)))
        return tuple(legs)

    def _leg(self, start: FloatArray, goal: FloatArray) -> FloatArray | None:
        """The shortest polyline between two places inside."""
        if shapely.covers(self._polygon, shapely.linestrings(np.stack([start, goal]))):
            return np.stack([start, goal])
        first, last = (int(self._tree.nearest(shapely.points(place))) for place in (start, goal))
        path = shortest_path(self._mesh, start, goal, first, last)
        return path if len(path) else None

    def _inside(self, stop: FloatArray) -> FloatArray | None:
        """The stop itself or, where it is too near a wall, the nearest place that is not."""
        point = shapely.points(stop)
        if shapely.intersects_xy(self._polygon, stop[0], stop[1]):
            return stop
        line = shapely.get_coordinates(shapely.shortest_line(self._polygon, point))
        step = line[0] - stop
        return line[0] if np.hypot(step[0], step[1]) <= self._longest_tie else None


def _without_repeats(points: FloatArray) -> FloatArray:
    """`points` (n, 2) without those equal to the one before, at least two."""
    kept = np.concatenate([[True], (np.diff(points, axis=0) != 0.0).any(axis=1)])
    return points[kept] if kept.sum() > 1 else points[[0, -1]]


def walls_kept(ways: Sequence[Way | None], radii: FloatArray, required: FloatArray) -> FloatArray:
    """(A,) what is `required` (A,) of distances to walls, m, with no more than ways leave."""
    kept = required.copy()
    for agent, way in enumerate(ways):
        if way is not None and way.clearance <= kept[agent]:
            kept[agent] = radii[agent] + 0.9 * (way.clearance - radii[agent])
    return kept
