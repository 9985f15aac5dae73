"""Shortest taut ways around the walls, one an agent, walked at constant speed.

Nobody heeds anybody else here: these curves start the relaxation where straight lines would cross
walls. A shortest way on the roadmap is pulled taut by replacing pieces of it with straight lines
that keep the agent's clearance, until that no longer shortens it.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.wall_distances import shortest_shortcut
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import requirement
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.graph import Graph
from stplan.seeding.search.roadmap import build_roadmap

# Clearance tried first, in radii: the widest margin that leaves a way keeps the band off the walls.
WIDEST_MARGIN = 1.05
PULLS = 3
# A taut way is cut to so many pieces at least before it is pulled again.
PIECES = 24


def geodesic_curves(problem: PlanningProblem) -> list[FloatArray | None]:
    """One (n, 3) curve an agent from its start time to the time it would like to arrive.

    None where an agent's stops are not connected at its radius. Prescribed paths are
    kept; agents that ignore walls, and all in the open plane, go straight.
    """
    ways = _geodesics(problem)
    curves: list[FloatArray | None] = []
    for agent, way in enumerate(ways):
        given = problem.paths[agent]
        if given is not None or way is None:
            curves.append(given)
            continue
        curves.append(
            _walked(way, float(problem.start_times[agent]), float(problem.preferred_times[agent]))
        )
    return curves


def _geodesics(problem: PlanningProblem) -> list[FloatArray | None]:
    """Plane polylines (n, 2), None where there is no way (or a prescribed path)."""
    stops, free_space = problem.stops, problem.free_space
    ways: list[FloatArray | None] = [
        points if len(points) and (free_space is None or not problem.heeds_walls[agent]) else None
        for agent, points in enumerate(stops)
    ]
    todo = [agent for agent, points in enumerate(stops) if ways[agent] is None and len(points) > 0]
    boundary = problem.boundary
    if free_space is None or boundary is None:
        return ways
    for margin in margin_ladder(WIDEST_MARGIN):
        if not todo:
            break
        walls = requirement(problem, margin).walls
        roadmap = build_roadmap(free_space, np.vstack(stops), walls[todo])
        place_of = np.split(roadmap.place_of, np.cumsum([len(points) for points in stops])[:-1])
        for agent in todo:
            radius = float(walls[agent])
            way = _shortest(roadmap.graph, place_of[agent], radius)
            if way is not None:
                legs = [_taut(boundary, leg, radius) for leg in way]
                ways[agent] = np.vstack([legs[0], *(leg[1:] for leg in legs[1:])])
        todo = [agent for agent in todo if ways[agent] is None]
    return ways


def _shortest(graph: Graph, places: IntArray, radius: float) -> list[FloatArray] | None:
    """Shortest polylines between consecutive `places` (vertices), None where there is none."""
    free = graph.free_moves(radius)[graph.num_vertices :]
    moves = graph.num_vertices + np.flatnonzero(free)
    shape = (graph.num_vertices, graph.num_vertices)
    lengths = csr_array(
        (graph.length[moves], (graph.move_from[moves], graph.move_to[moves])), shape=shape
    )
    legs = []
    for start, goal in pairwise(places):
        reached, before = dijkstra(lengths, indices=np.array([start]), return_predecessors=True)
        if not np.isfinite(reached[0, goal]):
            return None
        vertices = [int(goal)]
        while vertices[-1] != start:
            vertices.append(int(before[0, vertices[-1]]))
        legs.append(graph.vertices[vertices[::-1]])
    return legs


def _taut(walls: BoundaryGrid, way: FloatArray, radius: float) -> FloatArray:
    """`way` (n, 2) pulled taut, further than `radius` (m) from the walls."""
    length = _length(way)
    for _ in range(PULLS):
        way = _shortcut(walls, way, radius)
        if len(way) <= 2:
            break
        shorter = _length(way)
        if shorter > (1.0 - 1e-4) * length:
            break
        length = shorter
        way = _cut(way, length / PIECES)
    return _shortcut(walls, way, radius)


def _shortcut(walls: BoundaryGrid, way: FloatArray, radius: float) -> FloatArray:
    """The shortest polyline over knots of `way`, of pieces of it and of clear straight lines."""
    knots = shortest_shortcut(np.ascontiguousarray(way), radius, walls)
    return way[knots]


def _cut(way: FloatArray, step: float) -> FloatArray:
    """`way` with knots at most `step` (m) apart."""
    pieces = [way[:1]]
    for head, tail in pairwise(way):
        count = max(1, int(np.ceil(np.hypot(*(tail - head)) / step)))
        # The last point of a piece is its corner itself, to the last bit.
        share = np.arange(1, count)[:, None] / count
        pieces += [head + share * (tail - head), tail[None]]
    return np.vstack(pieces)


def _length(way: FloatArray) -> float:
    """Length of a polyline (n, 2) in m."""
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _walked(way: FloatArray, begin: float, end: float) -> FloatArray:
    """`way` (n, 2) at constant speed from `begin` to `end` (s); knots that coincide are dropped."""
    steps = np.hypot(*np.diff(way, axis=0).T)
    if steps.sum() <= 0.0:
        return np.column_stack([way[[0, -1]], [begin, end]])
    kept = np.concatenate([[True], steps > 0.0])
    way = way[kept]
    along = np.concatenate([[0.0], np.cumsum(steps[steps > 0.0])])
    times = begin + (end - begin) * along / along[-1]
    times[-1] = end
    return np.ascontiguousarray(np.column_stack([way, times]))
