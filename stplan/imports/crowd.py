"""Places for agents: drawn at random where they fit, and kept apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray, Point
from stplan.errors import UsageError
from stplan.world import FreeSpace, eroded

# Agents are placed with this factor on their radii, so that the first step needs no squeezing.
ROOM = 1.05
# So many places are tried for an agent.
MOST_TRIES = 300
# So many places are drawn at once.
DRAWN = 256
# And so many times, until an area is taken for a place.
MOST_DRAWS = 100


@dataclass(frozen=True)
class Trip:
    """From where to where."""

    start: Point
    goal: Point


class Placer:
    """Draws places of discs of one radius on a floor, none overlapping another.

    Args:
        free_space: the floor.
        radius: of the agents, m.
        rng: where chance comes from.
    """

    def __init__(self, free_space: FreeSpace, radius: float, rng: np.random.Generator) -> None:
        self.radius, self.rng = radius, rng
        room = shapely.get_parts(eroded(free_space.polygon, radius * ROOM))
        self.parts = [part for part in room if part.area > 0]
        self.starts = _Taken(2 * radius * ROOM)
        self.goals = _Taken(2 * radius * ROOM)

    def trips(
        self,
        count: int,
        sources: Sequence[Any] = (),
        goals: Sequence[Any] = (),
        *,
        share_goals: bool = False,
    ) -> list[Trip]:
        """Up to `count` trips, from one of the areas `sources` to one of `goals` (empty: anywhere).

        Args:
            share_goals: whether goals may lie on one another, of agents that vanish there.
        """
        wanted = shapely.union_all(np.array(sources, dtype=object)) if sources else None
        aimed = shapely.union_all(np.array(goals, dtype=object)) if goals else None
        from_parts = [_within(part, wanted) for part in self.parts]
        to_parts = [_within(part, aimed) for part in self.parts]
        both = [k for k in range(len(self.parts)) if from_parts[k].area and to_parts[k].area]
        if not both:
            return []
        weights = np.array([from_parts[k].area for k in both])
        found: list[Trip] = []
        for _ in range(MOST_TRIES * count):
            if len(found) == count:
                break
            part = both[int(self.rng.choice(len(both), p=weights / weights.sum()))]
            start = self.starts.fresh(from_parts[part].draw(self.rng))
            if start is None:
                continue
            goal = self._goal(to_parts[part], share_goals=share_goals)
            if goal is None:
                break
            self.starts.add(start)
            if not share_goals:
                self.goals.add(goal)
            found.append(Trip(start, goal))
        return found

    def goal_for(
        self, start: Point, goals: Sequence[Any] = (), spots: Sequence[Point] = ()
    ) -> Point | None:
        """A goal that can be reached from a start: in one of the areas `goals`, else one of the `spots`,
        else anywhere; None where there is none left."""
        aimed = shapely.union_all(np.array(goals, dtype=object)) if goals else None
        for part in self.parts:
            if not shapely.dwithin(part, shapely.Point(start), self.radius * ROOM):
                continue
            goal = None if goals else self._spot(part, start, spots)
            area = _within(part, aimed)
            if goal is None and area.area:
                goal = self._goal(area, share_goals=False)
            if goal is not None:
                self.goals.add(goal)
                return goal
        return None

    def take(self, start: Point, goal: Point) -> None:
        """Keep others off the places of an agent that is there already."""
        self.starts.add(start)
        self.goals.add(goal)

    def _spot(self, part: Any, start: Point, spots: Sequence[Point]) -> Point | None:
        """A spot at random that is free, has room, and is not where the agent stands."""
        for k in self.rng.permutation(len(spots)).tolist():
            spot = spots[k]
            if (
                np.hypot(spot[0] - start[0], spot[1] - start[1]) > 2 * self.radius
                and self.goals.fresh(spot) is not None
                and part.covers(shapely.Point(spot))
            ):
                return spot
        return None

    def _goal(self, area: _Area, *, share_goals: bool) -> Point | None:
        for _ in range(MOST_TRIES):
            place = area.draw(self.rng)
            goal = place if share_goals else self.goals.fresh(place)
            if goal is not None:
                return goal
        return None


class _Area:
    """An area from which places are drawn evenly: in the rectangle around it, until one lies inside."""

    def __init__(self, area: Any) -> None:
        self._shape = area
        self.area = float(area.area)
        shapely.prepare(area)
        self._found: list[Point] = []

    def draw(self, rng: np.random.Generator) -> Point:
        """A place."""
        low_x, low_y, high_x, high_y = self._shape.bounds
        for _ in range(MOST_DRAWS):
            if self._found:
                return self._found.pop()
            x, y = np.round(rng.uniform((low_x, low_y), (high_x, high_y), (DRAWN, 2)), 6).T
            inside = shapely.contains_xy(self._shape, x, y)
            self._found = list(zip(x[inside].tolist(), y[inside].tolist(), strict=True))
        # It is hardly there.
        place = shapely.point_on_surface(self._shape)
        return float(place.x), float(place.y)


class _Taken:
    """Places that are taken, in cells as wide as they have to be apart."""

    def __init__(self, apart: float) -> None:
        self.apart = apart
        self.cells: dict[tuple[int, int], list[Point]] = {}

    def fresh(self, place: Point) -> Point | None:
        """The place, None where it is too near one that is taken."""
        i, j = self._cell(place)
        near = (
            one
            for di in (-1, 0, 1)
            for dj in (-1, 0, 1)
            for one in self.cells.get((i + di, j + dj), ())
        )
        return (
            None
            if any(np.hypot(x - place[0], y - place[1]) < self.apart for x, y in near)
            else place
        )

    def add(self, place: Point) -> None:
        """Take a place."""
        self.cells.setdefault(self._cell(place), []).append(place)

    def _cell(self, place: Point) -> tuple[int, int]:
        return int(place[0] // self.apart), int(place[1] // self.apart)


def _within(part: Any, region: Any | None) -> _Area:
    area = part if region is None else shapely.intersection(part, region)
    pieces = [
        one for one in shapely.get_parts(area) if isinstance(one, shapely.Polygon) and one.area > 0
    ]
    return _Area(shapely.MultiPolygon(pieces))


def apart(places: FloatArray, distances: FloatArray) -> list[int]:
    """Indices of places (n, 2) kept: each further than the mean of `distances` (n,) from earlier ones."""
    kept: list[int] = []
    for k, place in enumerate(places):
        if kept:
            gaps = np.hypot(*(places[kept] - place).T)
            if (gaps <= (distances[kept] + distances[k]) / 2).any():
                continue
        kept.append(k)
    return kept


def no_room(count: int, wanted: int, radius: float) -> UsageError:
    """What to say where agents do not fit."""
    return UsageError(
        f"only {count} of {wanted} agents of radius {radius:g} m fit on the floor; fewer or smaller ones do"
    )
