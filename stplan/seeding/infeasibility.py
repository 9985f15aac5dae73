"""Why no clear curves were found: proven reasons, or where and when the best attempt still touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.rod_distances import rod_distance
from stplan.geometry.segments import closest_parameters
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.search.planner import LayeredPlanner, exact_points
from stplan.world import cut_off_agents, widest_passage

if TYPE_CHECKING:
    from stplan.world import FreeSpace

Kind = Literal[
    "start", "goal", "not connected", "roadmap", "layers", "order", "blocked", "touching"
]

# So many touching pairs are described.
MOST_PAIRS = 5


@dataclass(frozen=True)
class Reason:
    """One reason why there are no clear curves.

    Attributes:
        kind: what is wrong.
        agents: whom it concerns (indices).
        proven: no clear curves exist; else only this search found none.
        sentence: the same for people.
        place: (x, y) in m, where there is one.
        times: first and last time in s, where there are any.
    """

    kind: Kind
    agents: tuple[int, ...]
    proven: bool
    sentence: str
    place: tuple[float, float] | None = None
    times: tuple[float, float] | None = None


def hopeless(problem: PlanningProblem, free_space: FreeSpace | None) -> tuple[Reason, ...]:
    """Proven reasons: ends that touch, goals that cannot be reached."""
    reasons = [*_touching_ends(problem)]
    for agent in not_connected(problem, free_space, problem.radii):
        place = (float(problem.starts[agent, 0]), float(problem.starts[agent, 1]))
        sentence = _too_narrow(problem, agent, free_space)
        reasons.append(Reason("not connected", (agent,), True, sentence, place))
    return tuple(reasons)


def not_connected(
    problem: PlanningProblem, free_space: FreeSpace | None, radii: FloatArray
) -> list[int]:
    """Agents whose stops lie in different parts of the free space eroded by `radii` (A,)."""
    stops = [
        points if heeds else points[:0]
        for points, heeds in zip(exact_points(problem), problem.heeds_walls, strict=True)
    ]
    return cut_off_agents(free_space, stops, radii)


def _too_narrow(problem: PlanningProblem, agent: int, free_space: FreeSpace | None) -> str:
    """By how much the widest passage between the stops of an agent is too narrow for it."""
    name, radius = problem.agent_ids[agent], float(problem.radii[agent])
    stops = exact_points(problem)[agent]
    between = "its start, waypoints and goal" if len(stops) > 2 else "its start and goal"
    widest = 0.0 if free_space is None else widest_passage(free_space, stops, radius)
    if widest == 0.0:
        return f"{name}: {between} lie in separate parts of the map"
    return (
        f"{name}: no way connects {between} at its radius; the widest lets a radius of "
        f"{widest:.3g} m through, the agent's is {radius:g} m"
    )


def _touching_ends(problem: PlanningProblem) -> list[Reason]:
    """Starts at the same time and goals that are stayed on, closer than R; ends near given paths."""
    scale = np.array([1.0, 1.0, problem.time_scale])
    starts = np.column_stack([problem.starts, problem.start_times]) * scale
    given = problem.prescribed
    start_gaps = _distances(starts)
    near_starts = (start_gaps <= problem.distance) | given[:, None] | given[None]
    goal_gaps = _distances(problem.goals)
    stay = problem.stays[:, None] & problem.stays[None]
    near_goals = stay & (goal_gaps <= problem.distance)
    reasons = []
    for a, b in np.argwhere(np.triu(problem.collides & (near_starts | near_goals))):
        pair = (int(a), int(b))
        limit = float(problem.distance[pair])
        names = f"{problem.agent_ids[a]} and {problem.agent_ids[b]}"
        gap = _beginning_gap(problem, starts, pair, limit)
        if gap <= limit:
            sentence = f"{names} start {gap:.4g} m apart in space-time, not over {limit:.4g} m"
            if problem.start_times[a] != problem.start_times[b]:
                sentence += ", at this time_scale; a larger one keeps their times further apart"
            place = (float(starts[a, 0]), float(starts[a, 1]))
            reasons.append(Reason("start", pair, True, sentence, place))
        if near_goals[pair]:
            gap = float(goal_gaps[pair])
            sentence = f"{names} stay on goals {gap:.4g} m apart, not over {limit:.4g} m"
            place = (float(problem.goals[a, 0]), float(problem.goals[a, 1]))
            reasons.append(Reason("goal", pair, True, sentence, place))
    return reasons


def _distances(points: FloatArray) -> FloatArray:
    """(n, n) distances of `points` (n, d)."""
    return np.asarray(np.linalg.norm(points[:, None] - points[None], axis=2))


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


def stranded(problem: PlanningProblem, agents: Sequence[int], margin: float) -> tuple[Reason, ...]:
    """The roadmap of a margin does not connect `agents`."""
    return tuple(
        Reason(
            "roadmap",
            (agent,),
            False,
            f"{problem.agent_ids[agent]}: the roadmap has no way from start to goal "
            f"that keeps {margin:g} times the radius from the walls",
        )
        for agent in agents
    )


def off_mesh(problem: PlanningProblem, agents: Sequence[int], margin: float) -> tuple[Reason, ...]:
    """The seeding mesh does not connect `agents`."""
    return tuple(
        Reason(
            "roadmap",
            (agent,),
            False,
            f"{problem.agent_ids[agent]}: no edges of the mesh lead from start to goal at "
            f"{margin:g} times its radius from the walls; lower map.resolution",
        )
        for agent in agents
    )


def no_order(problem: PlanningProblem, failures: IntArray) -> tuple[Reason, ...]:
    """In no order tried did everybody find a way; `failures` (A,) counts who did not."""
    worst = [int(agent) for agent in np.argsort(-failures, kind="stable")[:MOST_PAIRS]]
    return tuple(
        Reason(
            "order",
            (agent,),
            False,
            f"{problem.agent_ids[agent]} found no way past the others in {failures[agent]} orders",
        )
        for agent in worst
        if failures[agent] > 0
    )


def late(problem: PlanningProblem, agents: Sequence[int], layers: int) -> tuple[Reason, ...]:
    """`layers` time layers are too few for `agents`."""
    return tuple(
        Reason(
            "layers",
            (agent,),
            False,
            f"{problem.agent_ids[agent]}: {layers} time layers are too few for its way; "
            "raise seeding.layers",
        )
        for agent in agents
    )


def no_way_past(planner: LayeredPlanner, group: Sequence[int]) -> tuple[Reason, ...]:
    """However the `group` moves, its members cannot get past each other on the roadmap."""
    names = " and ".join(planner.problem.agent_ids[agent] for agent in group)
    start = planner.problem.starts[group[0]]
    sentence = (
        f"{names} cannot get past each other, whatever detours they take: all their joint "
        f"positions on a roadmap of {planner.graph.num_vertices} points were searched"
    )
    place = (float(start[0]), float(start[1]))
    return (Reason("blocked", tuple(group), False, sentence, place),)


def stuck(
    problem: PlanningProblem, curves: Sequence[FloatArray], pairs: Sequence[tuple[int, int]]
) -> tuple[Reason, ...]:
    """Where and when the best curves found still touch."""
    reasons = []
    for a, b in pairs[:MOST_PAIRS]:
        place, times = _closest(problem.rod(a, curves[a]), problem.rod(b, curves[b]))
        times = (times[0] / problem.time_scale, times[1] / problem.time_scale)
        sentence = (
            f"{problem.agent_ids[a]} and {problem.agent_ids[b]} still block each other near "
            f"({place[0]:.2f}, {place[1]:.2f}) at {times[0]:.1f} to {times[1]:.1f} s"
        )
        reasons.append(Reason("touching", (a, b), False, sentence, place, times))
    if len(pairs) > MOST_PAIRS:
        others = tuple(sorted({agent for pair in pairs for agent in pair}))
        sentence = f"{len(pairs)} pairs of {len(others)} agents touch in the best curves found"
        reasons.append(Reason("touching", others, False, sentence))
    return tuple(reasons)


def _closest(
    first: FloatArray, second: FloatArray
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Plane point between the closest points of two rods, and their two heights in order; m."""
    least = np.inf
    place, heights = (0.0, 0.0), (0.0, 0.0)
    for p, q in pairwise(first):
        for u, v in pairwise(second):
            s, t, squared = closest_parameters(*p, *q, *u, *v)
            if squared < least:
                least = squared
                near, far = p + s * (q - p), u + t * (v - u)
                middle = (near + far) / 2
                place = (float(middle[0]), float(middle[1]))
                heights = (float(min(near[2], far[2])), float(max(near[2], far[2])))
    return place, heights
