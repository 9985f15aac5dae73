"""How near curves come to each other and to the walls: rods are thick polylines in (x, y, c t).

Rods whose distance exceeds R are enough for no collision. Everything here is exact between knots:
distances are those of segments, never of samples. Curves are (n, 3) arrays with columns x [m],
y [m], t [s]; prescribed paths are fixed and count as curves like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.rod_distances import segment_distances
from stplan.geometry.rod_neighbours import near_segments
from stplan.geometry.wall_distances import least_wall_distance
from stplan.problem.planning_problem import PlanningProblem

# Clear means further apart than R by more than rounding could feign.
STRICT = 1.0 + 1e-9


@dataclass(frozen=True)
class RodClearances:
    """How near the rods of colliding pairs come.

    Attributes:
        pairs: (N, 2) pairs a < b within reach, sorted.
        distance: (N,) their rod distance in m.
        violations: (a, b, distance) of the pairs not further apart than required.
    """

    pairs: IntArray
    distance: FloatArray
    violations: list[tuple[int, int, float]]


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
    pairs, gaps = near_pairs(problem, agent_rods(problem, curves), wanted, reach)
    limit = wanted[pairs[:, 0], pairs[:, 1]]
    broken = np.flatnonzero(gaps <= limit * STRICT)
    return RodClearances(
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
    return wall_distance(walls, curve[:-1, :2], curve[1:, :2], limit)


def crosses_boundary(problem: PlanningProblem, agent: int, curve: FloatArray) -> bool:
    """Whether a path touches or crosses a wall its agent heeds."""
    return wall_clearance(problem, agent, curve, 1e-9) <= 1e-12


def agent_rods(problem: PlanningProblem, curves: Sequence[FloatArray]) -> list[list[FloatArray]]:
    """The rod of every agent, a piece each."""
    return [[problem.rod(agent, curve)] for agent, curve in enumerate(curves)]


def near_pairs(
    problem: PlanningProblem,
    pieces: Sequence[Sequence[FloatArray]],
    reach: FloatArray,
    factor: float = 1.0,
) -> tuple[IntArray, FloatArray]:
    """Pairs (N, 2) of colliding agents nearer than `factor` times (A, A) `reach`, and their distance (N,)."""
    positions = np.vstack([piece for own in pieces for piece in own])
    counts = np.array([len(piece) for own in pieces for piece in own])
    owners = np.repeat(np.arange(len(pieces)), [len(own) for own in pieces])
    ends = np.cumsum(counts) - 1
    first = np.setdiff1d(np.arange(len(positions)), ends)
    segments = np.column_stack([first, first + 1]).astype(np.int64)
    agents = np.repeat(owners, counts - 1).astype(np.int64)
    near = near_segments(positions, segments, agents, problem.collides, reach, factor=factor)
    gaps = segment_distances(positions, segments, near)
    codes, inverse = np.unique(
        agents[near[:, 0]] * problem.num_agents + agents[near[:, 1]], return_inverse=True
    )
    least = np.full(len(codes), np.inf)
    np.minimum.at(least, inverse, gaps)
    pairs = np.column_stack([codes // problem.num_agents, codes % problem.num_agents])
    return pairs.astype(np.int64), least


def wall_distance(walls: BoundaryGrid, starts: FloatArray, ends: FloatArray, reach: float) -> float:
    """Least distance of plane segments (S, 2) to the walls in m, inf beyond `reach`."""
    heads = np.ascontiguousarray(starts)
    tails = np.ascontiguousarray(ends)
    near = walls.near(heads, tails, np.full(len(heads), reach))
    gap = least_wall_distance(heads, tails, near, walls.edges)
    return gap if gap <= reach else np.inf
