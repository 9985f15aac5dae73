"""Rods: world lines as thick polylines in (x, y, c t), and the proof that they are clear.

Rods whose distance exceeds R are enough for no collision. Everything here is exact between knots:
distances are those of segments, never of samples. Curves are (n, 3) arrays with columns x [m],
y [m], t [s]; `path` agents are fixed and count as curves like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.rod_distances import least_wall_distance, segment_distances
from stplan.geometry.rod_neighbours import near_segments
from stplan.problem.planning_problem import PlanningProblem

# Clear means further apart than R by more than rounding could feign.
STRICT = 1.0 + 1e-9
# A waypoint counts as passed, a given path as followed, within this distance (m).
PLACE_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Requirement:
    """Distances that curves have to exceed: (A, A) between rods and (A,) to the walls, in m."""

    rods: FloatArray
    walls: FloatArray


@dataclass(frozen=True)
class RodClearances:
    """How near the rods of colliding pairs come.

    Attributes:
        worst: least ratio of distance to requirement, inf where nothing is within reach.
        pairs: (N, 2) pairs a < b within reach, sorted.
        distance: (N,) their rod distance in m.
        violations: (a, b, distance) of the pairs not further apart than required.
    """

    worst: float
    pairs: IntArray
    distance: FloatArray
    violations: list[tuple[int, int, float]]


def requirement(problem: PlanningProblem, margin: float = 1.0) -> Requirement:
    """`margin` times R and r, but no more than what cannot move leaves possible.

    Where fixed ends of a pair (starts, goals with their tails, given paths) are nearer than the
    margin asks, half of what they leave over R is asked for; likewise for ends and waypoints
    near walls. The result is never below R.
    """
    pieces = [_fixed_pieces(problem, agent) for agent in range(problem.num_agents)]
    pairs, gaps = _near_pairs(problem, pieces, max(2.0 * margin - 1.0, 1.0) * problem.distance)
    excess = np.full_like(problem.distance, margin - 1.0)
    a, b = pairs.T
    left = 0.5 * (gaps / problem.distance[a, b] - 1.0)
    # Ends that touch already are beyond help, or kept apart in time: vanishing agents of one goal.
    excess[a, b] = np.where(left > 0.0, np.minimum(excess[a, b], left), excess[a, b])
    excess[b, a] = excess[a, b]
    walls = np.full(problem.num_agents, margin - 1.0)
    if problem.boundary is not None:
        for agent in np.flatnonzero(problem.heeds_walls & ~problem.prescribed):
            ends = [problem.starts[agent], problem.goals[agent], *problem.waypoints[agent]]
            reach = max(2.0 * margin - 1.0, 1.0) * float(problem.radii[agent])
            points = np.array(ends)
            gap = _wall_distance(problem.boundary, points, points, reach)
            walls[agent] = min(margin - 1.0, max(0.5 * (gap / problem.radii[agent] - 1.0), 0.0))
    return Requirement(problem.distance * (1.0 + excess), problem.radii * (1.0 + walls))


def held_requirement(
    problem: PlanningProblem, curves: Sequence[FloatArray], margin: float
) -> Requirement:
    """`requirement`, but no more than nine tenths of the clearance that `curves` already hold.

    Moves that keep to it never bring a pair closer than both the margin and the curves ask.
    """
    full = requirement(problem, margin)
    rods = full.rods.copy()
    pairs, gaps = _near_pairs(problem, _rods(problem, curves), 1.2 * rods)
    a, b = pairs.T
    held = problem.distance[a, b] + 0.9 * np.maximum(gaps - problem.distance[a, b], 0.0)
    rods[a, b] = np.minimum(rods[a, b], held)
    rods[b, a] = rods[a, b]
    walls = full.walls.copy()
    for agent, curve in enumerate(curves):
        gap = wall_clearance(problem, agent, curve, 1.2 * float(walls[agent]))
        radius = float(problem.radii[agent])
        walls[agent] = min(walls[agent], radius + 0.9 * max(gap - radius, 0.0))
    return Requirement(rods, walls)


def rod_clearances(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    required: FloatArray | None = None,
    *,
    reach: float = 1.5,
) -> RodClearances:
    """Rod distances of all colliding pairs nearer than `reach` times the (A, A) `required`.

    `required` defaults to R. The work grows linearly with the number of segments.
    """
    wanted = problem.distance if required is None else required
    pairs, gaps = _near_pairs(problem, _rods(problem, curves), reach * wanted)
    limit = wanted[pairs[:, 0], pairs[:, 1]]
    broken = np.flatnonzero(gaps <= limit * STRICT)
    return RodClearances(
        worst=float((gaps / limit).min(initial=np.inf)),
        pairs=pairs,
        distance=gaps,
        violations=[(int(pairs[k, 0]), int(pairs[k, 1]), float(gaps[k])) for k in broken],
    )


def wall_clearance(
    problem: PlanningProblem, agent: int, curve: FloatArray, reach: float | None = None
) -> float:
    """Distance of a path to the walls its agent heeds (m), inf beyond `reach` (default 2 r)."""
    walls = problem.wall_edges_heeded(agent)
    if walls is None:
        return np.inf
    limit = 2.0 * float(problem.radii[agent]) if reach is None else reach
    return _wall_distance(walls, curve[:-1, :2], curve[1:, :2], limit)


def crosses_boundary(problem: PlanningProblem, agent: int, curve: FloatArray) -> bool:
    """Whether a path touches or crosses a wall its agent heeds."""
    return wall_clearance(problem, agent, curve, 1e-9) <= 1e-12


def verify(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    margin: float | Requirement = 1.0,
) -> list[str]:
    """What is wrong with `curves`, one sentence each; empty proves them a clear seed.

    Ends and waypoints exact, times rising, arrival no later than `max_times`, rods and walls
    further than `margin` asks (see `requirement`; or an own requirement).
    """
    if len(curves) != problem.num_agents:
        return [f"{len(curves)} curves for {problem.num_agents} agents"]
    faults = [
        f"{name}: {fault}"
        for agent, name in enumerate(problem.agent_ids)
        for fault in _shape_faults(problem, agent, curves[agent])
    ]
    if faults:
        return faults
    wanted = margin if isinstance(margin, Requirement) else requirement(problem, margin)
    for a, b, gap in rod_clearances(problem, curves, wanted.rods, reach=1.01).violations:
        names = f"{problem.agent_ids[a]} and {problem.agent_ids[b]}"
        faults.append(f"{names}: rods {gap:.6g} m apart, not over {wanted.rods[a, b]:.6g} m")
    for agent, curve in enumerate(curves):
        limit = float(wanted.walls[agent])
        gap = wall_clearance(problem, agent, curve, 1.01 * limit)
        if gap <= limit * STRICT:
            faults.append(
                f"{problem.agent_ids[agent]}: {gap:.6g} m from a wall, not over {limit:.6g} m"
            )
    return faults


def _shape_faults(problem: PlanningProblem, agent: int, curve: FloatArray) -> list[str]:
    """What is wrong with one curve on its own."""
    if curve.ndim != 2 or curve.shape[1] != 3 or len(curve) < 2 or not np.isfinite(curve).all():
        return ["needs at least two finite knots"]
    faults = []
    if (np.diff(curve[:, 2]) <= 0).any():
        faults.append("time does not increase")
    if tuple(curve[0]) != (*problem.starts[agent], problem.start_times[agent]):
        faults.append("does not start at its start")
    if tuple(curve[-1, :2]) != tuple(problem.goals[agent]):
        faults.append("does not end at its goal")
    if curve[-1, 2] > problem.max_times[agent]:
        faults.append(f"arrives at {curve[-1, 2]} s, after {problem.max_times[agent]} s")
    if faults:
        return faults
    path = problem.paths[agent]
    if path is not None:
        times = np.union1d(path[:, 2], curve[:, 2])
        for x in range(2):
            ours = np.interp(times, curve[:, 2], curve[:, x])
            given = np.interp(times, path[:, 2], path[:, x])
            if np.abs(ours - given).max() > PLACE_TOLERANCE:
                return ["leaves its given path"]
    after = 0
    for number, point in enumerate(problem.waypoints[agent], start=1):
        hits = np.flatnonzero(np.abs(curve[after:, :2] - point).max(axis=1) <= PLACE_TOLERANCE)
        if not len(hits):
            return [f"has no knot on waypoint {number} in order"]
        after += int(hits[0])
    return []


def _rods(problem: PlanningProblem, curves: Sequence[FloatArray]) -> list[list[FloatArray]]:
    return [[problem.rod(agent, curve)] for agent, curve in enumerate(curves)]


def _fixed_pieces(problem: PlanningProblem, agent: int) -> list[FloatArray]:
    """Pieces of an agent's rod that hardly any seeding moves, as polylines in (x, y, c t)."""
    path = problem.paths[agent]
    if path is not None:
        return [problem.rod(agent, path)]
    start = [*problem.starts[agent], problem.time_scale * problem.start_times[agent]]
    last = problem.final_time if problem.stays[agent] else problem.max_times[agent]
    times = problem.time_scale * np.array([problem.max_times[agent], last])
    goal = np.column_stack([np.tile(problem.goals[agent], (2, 1)), times])
    return [np.array([start, start]), goal]


def _near_pairs(
    problem: PlanningProblem, pieces: Sequence[Sequence[FloatArray]], reach: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Pairs (N, 2) of colliding agents nearer than the (A, A) `reach`, and their distance (N,)."""
    positions = np.vstack([piece for own in pieces for piece in own])
    counts = np.array([len(piece) for own in pieces for piece in own])
    owners = np.repeat(np.arange(len(pieces)), [len(own) for own in pieces])
    ends = np.cumsum(counts) - 1
    first = np.setdiff1d(np.arange(len(positions)), ends)
    segments = np.column_stack([first, first + 1]).astype(np.int64)
    agents = np.repeat(owners, counts - 1).astype(np.int64)
    near = near_segments(positions, segments, agents, problem.collides, reach)
    gaps = segment_distances(positions, segments, near)
    codes, inverse = np.unique(
        agents[near[:, 0]] * problem.num_agents + agents[near[:, 1]], return_inverse=True
    )
    least = np.full(len(codes), np.inf)
    np.minimum.at(least, inverse, gaps)
    pairs = np.column_stack([codes // problem.num_agents, codes % problem.num_agents])
    return pairs.astype(np.int64), least


def _wall_distance(
    walls: BoundaryGrid, starts: FloatArray, ends: FloatArray, reach: float
) -> float:
    """Least distance of plane segments (S, 2) to the walls in m, inf beyond `reach`."""
    heads = np.ascontiguousarray(starts)
    tails = np.ascontiguousarray(ends)
    segment, edge = walls.near(heads, tails, np.full(len(heads), reach))
    gap = least_wall_distance(heads, tails, segment, edge, walls.edges)
    return gap if gap <= reach else np.inf
