"""Lengths that no way between stops can fall below, for agents of a radius among the walls.

A centre keeps its radius r from the walls. Were the walls' corners rounded by r, a shortest way would be made
of straight edges and of arcs around corners. Here arcs are replaced by chords between nodes on them: the area
grows by slivers, so its shortest ways are a little too short and never too long. They are among the ways over
a graph whose nodes lie on the arcs and whose edges keep r cos(d / 2) from the walls, d the angle between
neighbouring nodes: that is as near as a chord comes. More edges than needed only shorten ways further, so the
lengths are lower bounds whatever the map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.visibility import clear_segments, tangent_edges
from stplan.problem.planning_problem import PlanningProblem

if TYPE_CHECKING:
    from stplan.world.free_space import FreeSpace

# Greatest angles between nodes of an arc, rad: the finest one that leaves few enough nodes is taken. The
# first one makes an arc too short by less than 5e-4 of itself.
TURNS = tuple(np.radians([6.0, 15.0, 45.0, 90.0]))
MOST_NODES = 6000
# Agents of similar radii share a graph, that of the smallest of them, where there are more than so many.
MOST_GRAPHS = 8
# Shares by which radii and lengths are made smaller, against rounding.
ROUNDING = 1e-9
# Waypoints count as passed within this share of the radius.
PASSED_WITHIN = 1e-6
# Legs whose distances to all nodes are worked out at a time.
LEGS_AT_ONCE = 256


@dataclass(frozen=True)
class _Arcs:
    """Nodes on the arcs around corners.

    Attributes:
        nodes: (N, 2) m.
        normals: (N, 2) from the corner outwards.
        slack: (N,) |sine| of the angle to the tangent that edges may leave with.
        turn: greatest angle between neighbours, rad.
    """

    nodes: FloatArray
    normals: FloatArray
    slack: FloatArray
    turn: float


def shortest_lengths(problem: PlanningProblem) -> list[FloatArray]:
    """Lower bounds (w + 1,) of the lengths of ways between an agent's consecutive stops, m.

    An agent whose motion is prescribed has no stops and gets none.
    """
    return lengths_between(problem, problem.stops)


def lengths_between(problem: PlanningProblem, stops: Sequence[FloatArray]) -> list[FloatArray]:
    """The same between any `stops` (n, 2) of every agent: (n - 1,) m, none where it has none."""
    legs = [np.hypot(*np.diff(own, axis=0).T) for own in stops]
    free_space, boundary = problem.free_space, problem.boundary
    if free_space is not None and boundary is not None:
        heeding = [a for a, own in enumerate(stops) if problem.heeds_walls[a] and len(own)]
        for radius, agents in _groups(problem.radii, heeding):
            theirs = [stops[agent] for agent in agents]
            straight = [legs[agent] for agent in agents]
            found = _lengths(free_space, boundary, radius, theirs, straight)
            for agent, lengths in zip(agents, found, strict=True):
                legs[agent] = lengths
    return [
        np.maximum((1.0 - ROUNDING) * own - 2.0 * PASSED_WITHIN * radius * (len(own) > 1), 0.0)
        for own, radius in zip(legs, problem.radii, strict=True)
    ]


def _groups(radii: FloatArray, agents: Sequence[int]) -> list[tuple[float, list[int]]]:
    """Agents by radius; of many radii neighbouring ones share the smallest of theirs."""
    if not agents:
        return []
    distinct = np.unique(radii[agents])
    shares = np.array_split(distinct, min(len(distinct), MOST_GRAPHS))
    return [
        (float(share[0]), [a for a in agents if share[0] <= radii[a] <= share[-1]])
        for share in shares
    ]


def _lengths(
    free_space: FreeSpace,
    boundary: BoundaryGrid,
    radius: float,
    stops: Sequence[FloatArray],
    straight: Sequence[FloatArray],
) -> list[FloatArray]:
    """Lower bounds for agents of one radius: `straight` lengths where nothing better is known."""
    heads = np.vstack([points[:-1] for points in stops])
    tails = np.vstack([points[1:] for points in stops])
    lengths = np.concatenate(straight)
    ends = np.cumsum([len(own) for own in straight])[:-1]
    gap = (1.0 - ROUNDING) * radius
    bent = np.flatnonzero(~clear_segments(heads, tails, gap, boundary))
    arcs = _arcs(free_space, boundary, gap) if len(bent) else None
    if arcs is not None and len(arcs.nodes):
        ways = _around(boundary, gap, arcs, heads[bent], tails[bent])
        # Where the graph has no way, nothing is known but that it is not straight.
        lengths[bent] = np.where(np.isfinite(ways), np.maximum(ways, lengths[bent]), lengths[bent])
    return np.split(lengths, ends)


def _arcs(free_space: FreeSpace, boundary: BoundaryGrid, radius: float) -> _Arcs | None:
    """Nodes around every corner that free space bends around, None where there are too many."""
    bends = corners(free_space)
    for turn in TURNS:
        counts = np.maximum(np.ceil((bends[:, 3] - 1e-12) / turn), 1).astype(np.int64)
        if (counts + 1).sum() > 2 * MOST_NODES:
            continue
        owner = np.repeat(np.arange(len(bends)), counts + 1)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
        step = bends[owner, 3] / counts[owner]
        angle = bends[owner, 2] + step * number
        normals = np.column_stack([np.cos(angle), np.sin(angle)])
        nodes = bends[owner, :2] + radius * normals
        gap = radius * np.cos(turn / 2) * (1.0 - ROUNDING)
        usable = free_space.contains(nodes) & clear_segments(nodes, nodes, gap, boundary)
        if usable.sum() <= MOST_NODES:
            slack = np.sin(np.minimum(step / 2 + ROUNDING, np.pi / 2))
            return _Arcs(nodes[usable], normals[usable], slack[usable], float(turn))
    return None


def corners(free_space: FreeSpace) -> FloatArray:
    """(C, 4) corners that ways may bend around: x, y (m), first normal and span of the normals (rad).

    Between neighbouring edges at a corner there is room for an arc where they enclose more than half a turn.
    """
    return np.ascontiguousarray(corner_faces(free_space)[:, :4])


def corner_faces(free_space: FreeSpace) -> FloatArray:
    """(C, 6) the same, and how long the edges are (m) before the first normal and after the last."""
    edges, vertices = free_space.boundary_edges, free_space.boundary_vertices
    at = np.concatenate([edges[:, 0], edges[:, 1]])
    to = np.concatenate([edges[:, 1], edges[:, 0]])
    edge = vertices[to] - vertices[at]
    direction = np.arctan2(*edge.T[::-1])
    order = np.lexsort((direction, at))
    at, direction, length = at[order], direction[order], np.hypot(*edge[order].T)
    last = np.append(at[1:] != at[:-1], True)
    begins = np.flatnonzero(np.append(True, last[:-1]))
    following = np.append(direction[1:], 0.0)
    following[last] = direction[begins] + 2.0 * np.pi
    next_length = np.append(length[1:], 0.0)
    next_length[last] = length[begins]
    span = following - direction - np.pi
    turning = span > ROUNDING
    columns = [vertices[at], direction + np.pi / 2, span, length, next_length]
    return np.column_stack(columns)[turning]


def _around(
    boundary: BoundaryGrid, radius: float, arcs: _Arcs, heads: FloatArray, tails: FloatArray
) -> FloatArray:
    """(n,) lengths of the shortest ways from `heads` to `tails` (n, 2) over the arcs; inf without any."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    stops, place = np.unique(np.vstack([heads, tails]), axis=0, return_inverse=True)
    place = place.ravel()
    nodes = np.vstack([stops, arcs.nodes])
    normals = np.vstack([np.zeros_like(stops), arcs.normals])
    slack = np.concatenate([np.ones(len(stops)), arcs.slack])
    gap = radius * np.cos(arcs.turn / 2) * (1.0 - ROUNDING)
    edges = tangent_edges(nodes, normals, slack, len(stops), gap, boundary)
    lengths = np.hypot(*(nodes[edges[:, 0]] - nodes[edges[:, 1]]).T)
    graph = csr_array((lengths, (edges[:, 0], edges[:, 1])), shape=(len(nodes), len(nodes)))
    begins, ends = place[: len(heads)], place[len(heads) :]
    sources, row = np.unique(begins, return_inverse=True)
    found = np.empty(len(heads))
    for low, high in pairwise([*range(0, len(sources), LEGS_AT_ONCE), len(sources)]):
        reached = dijkstra(graph, directed=False, indices=sources[low:high])
        mine = _within(row.ravel(), low, high)
        found[mine] = reached[row.ravel()[mine] - low, ends[mine]]
    # A leg that is straight in the larger area of this graph is as short as that.
    seen = clear_segments(heads, tails, gap, boundary)
    return np.where(seen, np.minimum(found, np.hypot(*(tails - heads).T)), found)


def _within(rows: IntArray, low: int, high: int) -> IntArray:
    """Which of `rows` lie in low..high - 1."""
    return np.flatnonzero((rows >= low) & (rows < high))
