"""When to be where along a given way, among the rods of all others: the cheapest pace that is clear.

The way is cut into stops, the time into even steps. In every step an agent stands or goes straight on to
one of the next stops, which costs d^2 / (2 dt) of kinetic energy for a mass of one; a layered Dijkstra
search over (step, stop) finds the cheapest sequence whose every rod is clear. It does not leave the way, so
it is quick and finds nothing where somebody has to give way in space.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import TIME, in_metres, in_seconds
from stplan.compiled import kernel
from stplan.geometry.allocation import new_numbers
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.seeding.shortcutting.rod_field import RodField, build_field, segment_clear

# Steps of time, and stops on a way besides its own knots.
STEPS, STOPS = 64, 48
# In one step an agent passes at most so many times the stops that an even pace would.
HURRY = 4


def paced(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    agent: int,
    way: FloatArray,
    required: Requirement,
    unheeded: Sequence[int] = (),
) -> FloatArray | None:
    """The cheapest curve (STEPS + 1, 3) of an agent along `way` among the `curves` of all others.

    Args:
        curves: of everybody; that of the agent itself does not matter.
        way: (n, 2) from its start to its goal, waypoints among its points.
        required: what is to be kept.
        unheeded: agents that do not matter either.

    Returns:
        None where every pace touches something.
    """
    field = build_field(problem, curves, required)
    field.required[:, list(unheeded)] = -1.0
    stops, pinned = _stops(way, problem.waypoints[agent])
    # Steps are coarse: one stop at a time is never too fast, restoration sees to the rest.
    spacing = float(np.hypot(*np.diff(stops, axis=0).T).max(initial=0.0))
    limit = problem.scene.agents[agent].max_speed
    for arrival in dict.fromkeys((problem.preferred_times[agent], problem.max_times[agent])):
        times = np.linspace(problem.start_times[agent], arrival, STEPS + 1)
        longest = np.inf if limit is None else max(limit * (times[1] - times[0]), spacing)
        knots = in_metres(np.column_stack([np.zeros((len(times), 2)), times]), problem.time_scale)
        at = best_pace(field, agent, stops, pinned, knots[:, TIME].copy(), longest)
        if len(at):
            knots[:, :2] = stops[at]
            curve = in_seconds(knots, problem.time_scale)
            curve[:, TIME] = times
            return curve
    return None


def _stops(way: FloatArray, waypoints: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(K, 2) points along a way, all of its own among them, and which of them are not passed by."""
    lengths = np.hypot(*np.diff(way, axis=0).T)
    longest = lengths.sum() / STOPS
    points = [way[:1]]
    for begin, end, length in zip(way[:-1], way[1:], lengths, strict=True):
        if length <= 0.0:
            continue
        pieces = int(np.ceil(length / longest))
        inner = np.arange(1, pieces) / pieces
        points += [begin + inner[:, None] * (end - begin), end[None]]
    stops = np.ascontiguousarray(np.vstack(points))
    pinned = np.zeros(len(stops), dtype=bool)
    for point in waypoints:
        pinned |= (stops == point).all(axis=1)
    return stops, pinned


@kernel
def best_pace(
    field: RodField,
    agent: int,
    stops: FloatArray,
    pinned: BoolArray,
    times: FloatArray,
    longest: float,
) -> IntArray:
    """(N,) at which of the `stops` (K, 2) to be at `times` (N,) in c t, from the first to the last one.

    Nobody passes by `pinned` stops, or further than `longest` (m) in a step. Empty where nothing is clear.
    """
    num_times, num_stops = len(times), len(stops)
    most = max(HURRY * num_stops // (num_times - 1), 2)
    cost = new_numbers(num_times * num_stops)
    cost[:] = np.inf
    cost[0] = 0.0
    before = np.full(num_times * num_stops, -1, dtype=np.int64)
    p, q = new_numbers(3), new_numbers(3)
    goal = num_stops - 1
    # Who stays at its goal has to be clear there to the end.
    p[0], p[1], p[TIME] = stops[goal, 0], stops[goal, 1], times[-1]
    q[0], q[1], q[TIME] = p[0], p[1], max(times[-1], field.tops[agent])
    if not segment_clear(field, agent, p, q):
        return np.empty(0, dtype=np.int64)
    for n in range(1, num_times):
        p[TIME], q[TIME] = times[n - 1], times[n]
        for k in range(num_stops):
            q[0], q[1] = stops[k, 0], stops[k, 1]
            here = n * num_stops + k
            for back in range(min(most, k) + 1):
                source = k - back
                if back > 1 and pinned[source + 1]:
                    break
                step = np.hypot(q[0] - stops[source, 0], q[1] - stops[source, 1])
                if step > longest:
                    break
                total = cost[(n - 1) * num_stops + source] + step * step
                if total < cost[here]:
                    p[0], p[1] = stops[source, 0], stops[source, 1]
                    if segment_clear(field, agent, p, q):
                        cost[here] = total
                        before[here] = source
    if not np.isfinite(cost[num_times * num_stops - 1]):
        return np.empty(0, dtype=np.int64)
    at = np.empty(num_times, dtype=np.int64)
    at[-1] = goal
    for n in range(num_times - 1, 0, -1):
        at[n - 1] = before[n * num_stops + at[n]]
    return at
