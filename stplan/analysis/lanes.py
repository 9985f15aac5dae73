"""Straight lanes that agents cannot but go through from end to end, and who is opposed to whom in them.

A lane is a rectangle between two parallel walls. Who comes from one of its ends and leaves by the other, or
starts or ends within it, has a place along it: how far it is from the first end, or beyond an end. Where the
area in which a centre may be falls apart without the lane, such that no part touches both ends, whoever has
places on different sides of a stretch of the lane goes through all of that stretch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stplan.analysis.gates import HAIR, MOST_CORNERS, TIP, Gate, centres
from stplan.arrays import FloatArray, IntArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.shortest_ways import lengths_between

if TYPE_CHECKING:
    import shapely

    from stplan.world.free_space import FreeSpace

# Lanes are looked at up to so many times the largest radius wide: no two agents fit through side by side.
# They are longer than so many of the smallest one; so many of them, the longest first, so many pairs in each.
WIDEST, SHORTEST, MOST_LANES, MOST_PAIRS = 4.0, 2.0, 32, 100
# Walls are parallel where they part by no more than this share of the smallest radius.
PARALLEL = 1e-6


@dataclass(frozen=True)
class Lane:
    """A rectangle that is clear of walls inside.

    Attributes:
        origin: (2,) middle of the first end, m.
        along: (2,) unit vector from there to the other end.
        length, width: m.
    """

    origin: FloatArray
    along: FloatArray
    length: float
    width: float

    def point(self, place: float, beside: float = 0.0) -> FloatArray:
        """(2,) so far along the lane and left of its middle, m."""
        across = np.array([-self.along[1], self.along[0]])
        return self.origin + place * self.along + beside * across

    def across(self, place: float, half: float | None = None) -> FloatArray:
        """(2, 2) ends of the line across it at a place, all of it or up to `half` (m) from its middle."""
        half = 0.5 * self.width if half is None else half
        return np.array([self.point(place, -half), self.point(place, half)])

    def outline(self, begin: float, end: float, half: float) -> FloatArray:
        """(4, 2) corners of its part from `begin` to `end`, up to `half` (m) from its middle."""
        return np.concatenate([self.across(begin, half), self.across(end, half)[::-1]])


@dataclass(frozen=True)
class Opposed:
    """Two agents that go through a stretch of a lane, one up and one down it.

    Attributes:
        gates: across the begin and the end of the stretch; of both, the first agent is the one who goes up.
        room: whether who goes up finds room before the begin while the other one is there, and who comes down
            beyond the end.
    """

    gates: tuple[Gate, Gate]
    room: tuple[bool, bool]

    @property
    def agents(self) -> IntArray:
        """(2,) who goes up, and who comes down."""
        return self.gates[0].agents

    @property
    def middle(self) -> FloatArray:
        """(2,) of the stretch, m."""
        return np.mean([gate.ends for gate in self.gates], axis=(0, 1))


def find_lanes(problem: PlanningProblem, agents: Sequence[int]) -> list[Lane]:
    """Lanes too narrow for two of `agents` to pass each other, the longest first; none in the open."""
    space = problem.free_space
    heeding = [a for a in agents if problem.heeds_walls[a]]
    if space is None or len(heeding) < 2:
        return []
    radii = problem.radii[heeding]
    return _rectangles(space, float(radii.min()), WIDEST * float(radii.max()))


def _rectangles(space: FreeSpace, radius: float, widest: float) -> list[Lane]:
    """Rectangles between walls that face each other, for agents of at least `radius`."""
    import shapely

    walls = space.boundary_segments
    if len(walls) > MOST_CORNERS:
        return []
    heads, steps = walls[:, :2], walls[:, 2:] - walls[:, :2]
    lengths = np.hypot(*steps.T)
    kept = lengths > SHORTEST * radius
    heads, lengths, along = heads[kept], lengths[kept], steps[kept] / lengths[kept, None]
    found = []
    for i, (head, length, forward) in enumerate(zip(heads, lengths.tolist(), along, strict=True)):
        left = np.array([-forward[1], forward[0]])
        other = heads[i + 1 :] - head
        begin, height = other @ forward, other @ left
        run, rise = along[i + 1 :] @ forward, along[i + 1 :] @ left
        ends = begin + lengths[i + 1 :] * run
        low = np.maximum(np.minimum(begin, ends), 0.0)
        high = np.minimum(np.maximum(begin, ends), length)
        parallel = np.abs(rise) * lengths[i + 1 :] < PARALLEL * radius
        near = (np.abs(height) > 2.0 * radius) & (np.abs(height) < widest)
        for k in np.flatnonzero(parallel & near & (high - low > SHORTEST * radius)).tolist():
            origin = head + low[k] * forward + 0.5 * height[k] * left
            found.append(Lane(origin, forward, float(high[k] - low[k]), abs(float(height[k]))))
    found.sort(key=lambda lane: (-lane.length, *lane.origin.tolist()))
    tip = TIP * radius
    return [
        lane
        for lane in found
        if shapely.contains_properly(
            space.polygon,
            shapely.polygons(lane.outline(tip, lane.length - tip, 0.5 * lane.width - tip)),
        )
    ][:MOST_LANES]


def opposed_in(
    problem: PlanningProblem, lane: Lane, agents: Sequence[int], whole: Sequence[FloatArray]
) -> list[Opposed]:
    """Pairs of `agents` that have to keep clear of each other, go through a stretch of `lane` in
    opposite directions, and cannot pass each other there.

    Args:
        whole: (1,) lower bounds of the way of every agent of `problem` from start to goal, m.
    """
    sides = {
        float(radius): _sides(problem, lane, float(radius))
        for radius in np.unique(problem.radii[list(agents)])
    }
    spans: list[tuple[int, float, float]] = []
    for a in agents:
        parts = sides.get(float(problem.radii[a]))
        if parts is None or not problem.heeds_walls[a]:
            continue
        begin = _place(lane, parts, problem.starts[a])
        end = _place(lane, parts, problem.goals[a])
        if begin is not None and end is not None and begin != end:
            spans.append((a, begin, end))
    stretches = []
    for up, first, last in spans:
        for down, top, bottom in spans:
            low, high = max(first, bottom, 0.0), min(last, top, lane.length)
            apart = lane.width - float(problem.radii[up] + problem.radii[down])
            passing = apart < (1.0 - TIP) * float(problem.distance[up, down])
            if problem.collides[up, down] and passing and low < high:
                stretches.append((up, down, low, high))
    stretches.sort(key=lambda one: (one[2] - one[3], one[0], one[1]))
    return _measured(problem, lane, stretches[:MOST_PAIRS], sides, whole)


_Sides = tuple["shapely.Geometry", "shapely.Geometry"]


def _sides(problem: PlanningProblem, lane: Lane, radius: float) -> _Sides | None:
    """Where centres may be that touches the first end, and the other; None where a part touches both."""
    space = problem.free_space
    if space is None or lane.width <= 2.0 * radius:
        return None
    import shapely

    hair = HAIR * radius
    inside = shapely.polygons(lane.outline(0.0, lane.length, 0.5 * lane.width))
    parts = shapely.get_parts(shapely.difference(centres(space, radius), inside))
    half = 0.5 * lane.width - radius
    touching = []
    for place in (0.0, lane.length):
        end = shapely.polygons(lane.outline(place - hair, place + hair, half + hair))
        touching.append(shapely.intersects(parts, end))
    if (touching[0] & touching[1]).any():
        return None
    return shapely.union_all(parts[touching[0]]), shapely.union_all(parts[touching[1]])


def _place(lane: Lane, sides: _Sides, point: FloatArray) -> float | None:
    """How far along the lane a point (2,) is, -inf or inf beyond its ends, None elsewhere."""
    import shapely

    offset = point - lane.origin
    place = float(offset @ lane.along)
    beside = float(offset @ np.array([-lane.along[1], lane.along[0]]))
    if 0.0 <= place <= lane.length and abs(beside) < 0.5 * lane.width:
        return place
    for side, value in zip(sides, (-np.inf, np.inf), strict=True):
        if shapely.contains_xy(side, *point.tolist()):
            return value
    return None


def _measured(
    problem: PlanningProblem,
    lane: Lane,
    stretches: Sequence[tuple[int, int, float, float]],
    sides: dict[float, _Sides | None],
    whole: Sequence[FloatArray],
) -> list[Opposed]:
    """The pairs with their ways, measured to the middles of both ends of their stretches."""
    asked = sorted({(a, x) for *pair, low, high in stretches for a in pair for x in (low, high)})
    stops: list[list[FloatArray]] = [[] for _ in range(problem.num_agents)]
    where: dict[tuple[int, float], int] = {}
    for a, place in asked:
        where[a, place] = len(stops[a])
        stops[a] += [problem.starts[a], lane.point(place), problem.goals[a]]
    ways = lengths_between(problem, [np.array(own).reshape(-1, 2) for own in stops])

    def gate(pair: tuple[int, int], place: float) -> Gate:
        radii = problem.radii[list(pair)]
        first = [where[a, place] for a in pair]
        legs = np.array([ways[a][i : i + 2] for a, i in zip(pair, first, strict=True)])
        aside = 0.5 * lane.width - radii + HAIR * radii
        before, after = np.maximum(legs - aside[:, None], 0.0).T
        own = np.array([float(whole[a].sum()) for a in pair])
        return Gate(lane.across(place), lane.width, np.array(pair), before, after, own)

    found = []
    for up, down, low, high in stretches:
        gates = gate((up, down), low), gate((up, down), high)
        room = (
            _room(problem, lane, sides, up, down, low, 0),
            _room(problem, lane, sides, down, up, high, 1),
        )
        found.append(Opposed(gates, room))
    return found


def _room(
    problem: PlanningProblem,
    lane: Lane,
    sides: dict[float, _Sides | None],
    agent: int,
    other: int,
    place: float,
    side: int,
) -> bool:
    """Whether `agent` finds room on a side of a place along the lane while the `other` one is there.

    That one is somewhere between two points; who is within reach of both is within reach of all between.
    """
    import shapely

    parts = sides[float(problem.radii[agent])]
    if parts is None:
        return True
    passing = lane.across(place, 0.5 * lane.width - float(problem.radii[other]))
    edges = [
        lane.across(end, 0.5 * lane.width - float(problem.radii[agent]))
        for end in (place, side * lane.length)
    ]
    points = np.vstack([*edges, shapely.get_coordinates(parts[side])])
    far = np.hypot(*(points[:, None] - passing).transpose(2, 0, 1))
    return bool((far > (1.0 - TIP) * float(problem.distance[agent, other])).any())
