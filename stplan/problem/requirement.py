"""The distances that curves have to exceed: a margin over R and r where that is possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.clearance import agent_rods, near_pairs, wall_clearance, wall_distance
from stplan.problem.planning_problem import PlanningProblem


@dataclass(frozen=True)
class Requirement:
    """Distances that curves have to exceed: (A, A) between rods and (A,) to the walls, in m."""

    rods: FloatArray
    walls: FloatArray


def least_requirement(problem: PlanningProblem) -> Requirement:
    """R and r themselves."""
    return Requirement(problem.distance, problem.radii)


def requirement(problem: PlanningProblem, margin: float) -> Requirement:
    """`margin` times R and r, but no more than what cannot move leaves possible.

    Where fixed ends of a pair (starts, goals with their tails, prescribed paths) are nearer than the
    margin asks, half of what they leave over R is asked for; likewise for ends and waypoints
    near walls. The result is never below R.
    """
    pieces = [_fixed_pieces(problem, agent) for agent in range(problem.num_agents)]
    pairs, gaps = near_pairs(problem, pieces, problem.distance, max(2.0 * margin - 1.0, 1.0))
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
            gap = wall_distance(problem.boundary, points, points, reach)
            walls[agent] = min(margin - 1.0, max(0.5 * (gap / problem.radii[agent] - 1.0), 0.0))
    excess += 1.0
    excess *= problem.distance
    return Requirement(excess, problem.radii * (1.0 + walls))


def held_requirement(
    problem: PlanningProblem, curves: Sequence[FloatArray], full: Requirement
) -> Requirement:
    """`full`, but no more than nine tenths of the clearance that `curves` already hold.

    Moves that keep to it never bring a pair closer than both the requirement and the curves ask.
    """
    rods = full.rods.copy()
    pairs, gaps = near_pairs(problem, agent_rods(problem, curves), rods, 1.2)
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
