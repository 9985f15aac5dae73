"""Why no clear curves were found: proven reasons, or where and when the best attempt still touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.axes import PLACE, TIME
from stplan.geometry.rod_distances import closest_points, rod_distance
from stplan.problem.planning_problem import PlanningProblem
from stplan.reasons import Kind, Reason

# So many touching pairs are described.
MOST_PAIRS = 5


def hopeless(problem: PlanningProblem) -> tuple[Reason, ...]:
    """Proven reasons: ends that touch, goals that cannot be reached."""
    cut_off = not_connected(problem, problem.radii)
    return (*_touching_ends(problem), *(_too_narrow(problem, agent) for agent in cut_off))


def not_connected(problem: PlanningProblem, radii: FloatArray) -> list[int]:
    """Agents whose stops lie in different parts of the free space eroded by `radii` (A,)."""
    if problem.free_space is None:
        return []
    from stplan.world import cut_off_agents

    stops = [
        points if heeds else points[:0]
        for points, heeds in zip(problem.stops, problem.heeds_walls, strict=True)
    ]
    return cut_off_agents(problem.free_space, stops, radii)


def _too_narrow(problem: PlanningProblem, agent: int) -> Reason:
    """By how much the widest passage between the stops of an agent is too narrow for it."""
    radius = float(problem.radii[agent])
    stops = problem.stops[agent]
    space, widest, crack = problem.free_space, 0.0, 0.0
    if space is not None:
        from stplan.world import widest_crack, widest_passage

        widest = widest_passage(space, stops, radius)
        crack = widest_crack(space, stops, radius)
    return Reason(
        "not connected",
        (problem.agent_ids[agent],),
        proven=True,
        place=_point(problem.starts[agent]),
        figures={"stops": len(stops), "widest": widest, "radius": radius, "distance": crack},
    )


def _touching_ends(problem: PlanningProblem) -> list[Reason]:
    """Starts at the same time and goals that are stayed on, closer than R; ends near given paths."""
    scale = np.array([1.0, 1.0, problem.time_scale])
    starts = np.column_stack([problem.starts, problem.start_times]) * scale
    count, given = problem.num_agents, problem.prescribed
    reach = float(problem.distance.max(where=problem.collides, initial=0.0))
    near_starts, _ = _near(problem, starts, reach)
    beside_given = np.array(np.meshgrid(np.flatnonzero(given), np.arange(count))).reshape(2, -1).T
    goals, goal_gaps = _near(problem, problem.goals, reach)
    stay = problem.stays[goals].all(axis=1)
    near_goals = {
        (a, b): gap
        for (a, b), gap in zip(goals[stay].tolist(), goal_gaps[stay].tolist(), strict=True)
    }
    candidates = np.sort(np.vstack([near_starts, beside_given, goals[stay]]), axis=1)
    candidates = candidates[problem.collides[candidates[:, 0], candidates[:, 1]]]
    codes = np.unique(candidates[:, 0] * count + candidates[:, 1])
    reasons = []
    for a, b in np.column_stack(np.divmod(codes, count)).tolist():
        pair = (a, b)
        limit = float(problem.distance[pair])
        gap = _beginning_gap(problem, starts, pair, limit)
        if gap <= limit:
            early, late = sorted(problem.start_times[list(pair)].tolist())
            found = _touching_pair(problem, "start", pair, gap, problem.starts[a])
            reasons.append(replace(found, times=(early, late)))
        if pair in near_goals:
            gap = near_goals[pair]
            reasons.append(_touching_pair(problem, "goal", pair, gap, problem.goals[a]))
    return reasons


def _touching_pair(
    problem: PlanningProblem, kind: Kind, pair: tuple[int, int], gap: float, place: FloatArray
) -> Reason:
    """Two ends `gap` (m) apart, near `place` (2,)."""
    figures = {"distance": gap, "required": float(problem.distance[pair])}
    return Reason(kind, _ids(problem, pair), proven=True, place=_point(place), figures=figures)


def _ids(problem: PlanningProblem, agents: Sequence[int]) -> tuple[str, ...]:
    return tuple(problem.agent_ids[agent] for agent in agents)


def _point(place: FloatArray) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _near(
    problem: PlanningProblem, points: FloatArray, reach: float
) -> tuple[IntArray, FloatArray]:
    """Pairs (N, 2) of agents a < b whose `points` (A, d) are no further apart than R, and how far (N,).

    R is at most `reach`: along the axis on which points spread most, only those within it are looked at.
    """
    along = points[:, int(np.ptp(points, axis=0).argmax())]
    order = np.argsort(along, kind="stable")
    # A little further: differences are rounded.
    past = np.searchsorted(along[order], along[order] + (1.0 + 1e-9) * reach, side="right")
    counts = np.maximum(past - np.arange(len(order)) - 1, 0)
    first = np.repeat(np.arange(len(order)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    pairs = np.sort(np.column_stack([order[first], order[second]]), axis=1)
    gaps = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    near = gaps <= problem.distance[pairs[:, 0], pairs[:, 1]]
    return pairs[near], gaps[near]


def _beginning_gap(
    problem: PlanningProblem, starts: FloatArray, pair: tuple[int, int], limit: float
) -> float:
    """Distance of what cannot move of two agents' beginnings: start points or given paths; m."""
    rods = []
    for agent in pair:
        path = problem.paths[agent]
        point = np.array([starts[agent], starts[agent]])
        rods.append(point if path is None else problem.rod(agent, path))
    return rod_distance(rods[0], rods[1], 1.5 * limit)


def stranded(
    problem: PlanningProblem, agents: Sequence[int], margin: float, kind: Kind = "roadmap"
) -> tuple[Reason, ...]:
    """The roadmap (or the "mesh") of a margin does not connect `agents`."""
    return tuple(
        Reason(kind, (problem.agent_ids[agent],), figures={"margin": margin}) for agent in agents
    )


def no_order(problem: PlanningProblem, failures: IntArray) -> tuple[Reason, ...]:
    """In no order tried did everybody find a way; `failures` (A,) counts who did not."""
    worst = [int(agent) for agent in np.argsort(-failures, kind="stable")[:MOST_PAIRS]]
    return tuple(
        Reason("order", (problem.agent_ids[agent],), figures={"orders": int(failures[agent])})
        for agent in worst
        if failures[agent] > 0
    )


def too_few_layers(
    problem: PlanningProblem, agents: Sequence[int], layers: int
) -> tuple[Reason, ...]:
    """`layers` time layers are too few for `agents`."""
    return tuple(
        Reason("layers", (problem.agent_ids[agent],), figures={"layers": layers})
        for agent in agents
    )


def no_way_past(
    problem: PlanningProblem, group: Sequence[int], num_vertices: int
) -> tuple[Reason, ...]:
    """However the `group` moves, its members cannot get past each other on a roadmap of so many vertices."""
    reason = Reason(
        "blocked",
        _ids(problem, group),
        place=_point(problem.starts[group[0]]),
        figures={"vertices": num_vertices},
    )
    return (reason,)


def touching(
    problem: PlanningProblem, curves: Sequence[FloatArray], pairs: Sequence[tuple[int, int]]
) -> tuple[Reason, ...]:
    """Where and when the best curves found still touch."""
    reasons = []
    for a, b in pairs[:MOST_PAIRS]:
        place, (low, high) = _closest(problem.rod(a, curves[a]), problem.rod(b, curves[b]))
        times = (low / problem.time_scale, high / problem.time_scale)
        reasons.append(Reason("touching", _ids(problem, (a, b)), place=place, times=times))
    if len(pairs) > MOST_PAIRS:
        others = _ids(problem, sorted({agent for pair in pairs for agent in pair}))
        reasons.append(Reason("touching", others, figures={"pairs": len(pairs)}))
    return tuple(reasons)


def _closest(
    first: FloatArray, second: FloatArray
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Plane point between the closest points of two rods, and their two heights in order; m."""
    near, far = closest_points(first, second)
    middle = (near[PLACE] + far[PLACE]) / 2
    low, high = sorted([float(near[TIME]), float(far[TIME])])
    return (float(middle[0]), float(middle[1])), (low, high)
