"""Narrow gates that agents cannot but pass, and how far they travel before and after.

A gate is a straight line between two points of the walls that is clear of walls in between. It parts the area
in which the centre of an agent may be, so whoever starts on one side of it and ends on the other passes it at
some instant. The centre is then further than its radius from both ends of the line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.geometry.visibility import clear_segments
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.shortest_ways import corners, lengths_between

if TYPE_CHECKING:
    import shapely

    from stplan.world.free_space import FreeSpace

# Gates are looked at up to so many times the largest radius wide: no two agents fit through side by side.
WIDEST = 4.0
# So many of them, the narrowest first, in maps with at most so many corners to bend around.
MOST_GATES, MOST_CORNERS = 64, 1500
# Gates whose ends are nearer to each other's than this share of the smallest radius are the same.
SAME = 0.05
# Ends of gates are left out where it is asked whether walls cross them, and gates are widened by the second
# where they part areas: shares of the smallest radius.
TIP, HAIR = 1e-6, 1e-7


@dataclass(frozen=True)
class Gate:
    """A line that agents have to pass.

    Attributes:
        ends: (2, 2) on the walls, m.
        width: m.
        agents: (n,) who has to pass it, sorted.
        before, after: (n,) lower bounds of their ways to it and on from it, m.
        whole: (n,) of their ways from start to goal, m.
    """

    ends: FloatArray
    width: float
    agents: IntArray
    before: FloatArray
    after: FloatArray
    whole: FloatArray

    def only(self, kept: BoolArray) -> Gate:
        """The same for the agents that are `kept` (n,)."""
        return Gate(
            self.ends, self.width, self.agents[kept],
            self.before[kept], self.after[kept], self.whole[kept],
        )  # fmt: skip


def find_gates(
    problem: PlanningProblem,
    agents: Sequence[int],
    whole: Sequence[FloatArray],
    widest: float = WIDEST,
) -> list[Gate]:
    """Gates that at least two of `agents` have to pass, the narrowest first; none in the open.

    Args:
        agents: those that may be asked, who have no waypoint. Of those who end in places the way on from the
            gate leads to their present goal.
        whole: (1,) lower bounds of the way of every agent of `problem` from start to goal, m.
        widest: largest width over the largest radius.
    """
    space = problem.free_space
    heeding = [a for a in agents if problem.heeds_walls[a]]
    if space is None or len(heeding) < 2:
        return []
    lines = _lines(space, widest * float(problem.radii[heeding].max()), problem.radii.min())
    passing = [(line, _who_passes(problem, line, heeding)) for line in lines]
    passing = [(line, who) for line, who in passing if len(who) > 1]
    if not passing:
        return []
    return _measured(problem, passing, whole)


def _lines(space: FreeSpace, widest: float, least_radius: float) -> FloatArray:
    """(G, 2, 2) candidates, the narrowest first: from corners to others, or straight across to walls."""
    import shapely

    bends = np.unique(corners(space)[:, :2], axis=0)
    if not 0 < len(bends) <= MOST_CORNERS:
        return np.empty((0, 2, 2))
    i, j = np.triu_indices(len(bends), 1)
    found = [np.stack([bends[i], bends[j]], axis=1)]
    for corner in bends:
        heads, tails = space.boundary_segments[:, :2], space.boundary_segments[:, 2:]
        along = tails - heads
        share = ((corner - heads) * along).sum(axis=1) / (along**2).sum(axis=1)
        across = heads + share[:, None] * along
        inner = (share > 0.0) & (share < 1.0)
        found.append(np.stack([np.broadcast_to(corner, across.shape), across], axis=1)[inner])
    lines = np.concatenate(found)
    widths = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    kept = (widths < widest) & (widths > 2.0 * least_radius)
    lines, widths = lines[kept], widths[kept]
    tip = (TIP * least_radius / widths)[:, None]
    step = lines[:, 1] - lines[:, 0]
    inside = shapely.linestrings(np.stack([lines[:, 0] + tip * step, lines[:, 1] - tip * step], 1))
    clear = shapely.contains_properly(space.polygon, inside)
    lines, widths = lines[clear], widths[clear]
    order = np.lexsort((*lines.reshape(-1, 4).T, np.round(widths / least_radius, 9)))
    return _distinct(lines[order], SAME * least_radius)


def _distinct(lines: FloatArray, apart: float) -> FloatArray:
    """The first `MOST_GATES` of `lines` (G, 2, 2), of similar ones only the first."""
    kept: list[FloatArray] = []
    for line in lines:
        same = any(
            min(np.abs(line - other).max(), np.abs(line[::-1] - other).max()) < apart
            for other in kept
        )
        if not same:
            kept.append(line)
        if len(kept) == MOST_GATES:
            break
    return np.array(kept).reshape(-1, 2, 2)


def _who_passes(problem: PlanningProblem, line: FloatArray, agents: Sequence[int]) -> list[int]:
    """Those of `agents` that have to pass `line` (2, 2), and that it leaves room for."""
    space = problem.free_space
    if space is None:
        return []
    import shapely

    width = float(np.hypot(*(line[1] - line[0])))
    hair = HAIR * float(problem.radii.min())
    strip = shapely.buffer(shapely.linestrings(line), hair, cap_style="flat")
    found = []
    for radius in np.unique(problem.radii[agents]):
        mine = [a for a in agents if problem.radii[a] == radius]
        if 2.0 * radius >= width or not _clear_between(problem, line, float(radius)):
            continue
        parts = shapely.get_parts(shapely.difference(centres(space, float(radius)), strip))
        begin = _part(parts, problem.starts[mine])
        end = _part(parts, problem.goals[mine])
        parted = (begin >= 0) & (end >= 0) & (begin != end)
        found += [
            a
            for a, passes, part in zip(mine, parted.tolist(), begin.tolist(), strict=True)
            if passes
            and not any(
                shapely.intersects(parts[part], place.shape())
                for place in problem.scene.agents[a].goal_places
            )
        ]
    return sorted(found)


def _clear_between(problem: PlanningProblem, line: FloatArray, radius: float) -> bool:
    """Whether a centre can move along `line` (2, 2) from one end to the other but for its radius."""
    if problem.boundary is None:
        return False
    inset = radius * (line[1] - line[0]) / float(np.hypot(*(line[1] - line[0])))
    heads, tails = (line[0] + inset)[None], (line[1] - inset)[None]
    return bool(clear_segments(heads, tails, (1.0 - TIP) * radius, problem.boundary)[0])


def centres(space: FreeSpace, radius: float) -> shapely.Geometry:
    """Where centres of discs of `radius` (m) may be, and a sliver more: arcs are replaced by chords."""
    from stplan.world import eroded

    return eroded(space.polygon, radius)


def _part(parts: FloatArray, points: FloatArray) -> IntArray:
    """(n,) which of `parts` holds each point (n, 2), -1 for none."""
    import shapely

    result = np.full(len(points), -1, dtype=np.int64)
    for number, part in enumerate(parts):
        result[shapely.contains_xy(part, points[:, 0], points[:, 1])] = number
    return result


def _measured(
    problem: PlanningProblem,
    passing: Sequence[tuple[FloatArray, list[int]]],
    whole: Sequence[FloatArray],
) -> list[Gate]:
    """The gates with the ways of those that pass them, measured to their middles.

    From the middle to wherever a centre passes the line it is at most half of what the radius leaves of it.
    """
    stops: list[list[FloatArray]] = [[] for _ in range(problem.num_agents)]
    for line, who in passing:
        for a in who:
            stops[a] += [problem.starts[a], line.mean(axis=0), problem.goals[a]]
    ways = lengths_between(problem, [np.array(own).reshape(-1, 2) for own in stops])
    taken = [0] * problem.num_agents
    gates = []
    for line, who in passing:
        width = float(np.hypot(*(line[1] - line[0])))
        legs = []
        for a in who:
            aside = 0.5 * width - float(problem.radii[a])
            legs.append(ways[a][taken[a] : taken[a] + 2] - aside - HAIR * problem.radii[a])
            taken[a] += 3
        before, after = np.maximum(np.array(legs), 0.0).T
        own = np.array([float(whole[a].sum()) for a in who])
        gates.append(Gate(line, width, np.array(who), before, after, own))
    return gates
