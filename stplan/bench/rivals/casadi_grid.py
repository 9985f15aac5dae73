"""What one would write with CasADi: positions on one common grid of times, least duration, by Ipopt."""

from __future__ import annotations

from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.bench.rivals.task import Motion, Task, no_motion

PACKAGE = "casadi"
NAME = "CasADi and Ipopt, straight lines first"
NAME_WARM = "CasADi and Ipopt, from our initial curves"

KNOTS = 60
MAX_ITERATIONS = 1000
# Straight lines bend by so much (m), differently each, or opposite agents would never let go.
BOW = 0.3
SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


def drive(task: Task) -> Motion:
    """From straight lines, each bent a little."""
    rng = np.random.default_rng(0)
    along = np.linspace(0.0, 1.0, KNOTS + 1)[:, None]
    guess = [
        start + along * (goal - start) + np.sin(np.pi * along) * rng.uniform(-BOW, BOW, 2)
        for start, goal in zip(task.starts, task.goals, strict=True)
    ]
    longest = float(np.hypot(*(task.goals - task.starts).T).max())
    return _solved(task, guess, 1.2 * longest / task.speed)


def drive_warm(task: Task) -> Motion:
    """From the initial curves, which are clear of each other and of the walls."""
    duration = max(float(curve[-1, 2]) for curve in task.curves)
    times = np.linspace(0.0, duration, KNOTS + 1)
    guess = [
        np.column_stack([np.interp(times, curve[:, 2], curve[:, axis]) for axis in range(2)])
        for curve in task.curves
    ]
    return _solved(task, guess, duration)


def _solved(task: Task, guess: list[FloatArray], duration: float) -> Motion:
    import casadi

    count = len(guess)
    inner = casadi.MX.sym("inner", 2 * count, KNOTS - 1)
    total = casadi.MX.sym("total")
    step = total / KNOTS
    places = [
        casadi.horzcat(start, inner[2 * agent : 2 * agent + 2, :], goal)
        for agent, (start, goal) in enumerate(zip(task.starts, task.goals, strict=True))
    ]
    rows: list[Any] = []
    for place in places:
        move = casadi.diff(place, 1, 1)
        still = casadi.DM.zeros(2, 1)
        change = casadi.diff(casadi.horzcat(still, move, still), 1, 1)
        rows.append((task.speed * step) ** 2 - casadi.sum1(move**2))
        rows.append((task.acceleration * step**2) ** 2 - casadi.sum1(change**2))
    for a in range(count):
        for b in range(a + 1, count):
            needed = float(task.radii[a] + task.radii[b])
            rows.append(casadi.sum1((places[a] - places[b])[:, 1:-1] ** 2) - needed**2)
    rows += _walls(task, places)
    positive = casadi.horzcat(*rows).T
    solver = casadi.nlpsol(
        "solver",
        "ipopt",
        {"x": casadi.vertcat(casadi.vec(inner), total), "f": total, "g": positive},
        {
            "print_time": False,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "max_iter": MAX_ITERATIONS,
                "max_wall_time": task.time_limit,
            },
        },
    )
    first = np.vstack([place.T[:, 1:-1] for place in guess])
    answer = solver(x0=np.append(first.T.ravel(), duration), lbg=0.0)
    status = solver.stats()["return_status"]
    if status not in SOLVED:
        return no_motion(count, status.replace("_", " ").lower())
    values = np.asarray(answer["x"]).ravel()
    times = np.linspace(0.0, values[-1], KNOTS + 1)
    found = values[:-1].reshape(KNOTS - 1, count, 2)
    curves = [
        np.column_stack([np.vstack([start, found[:, agent], goal]), times])
        for agent, (start, goal) in enumerate(zip(task.starts, task.goals, strict=True))
    ]
    return Motion(curves, np.ones(count, dtype=bool), rests=True)


def _walls(task: Task, places: list[Any]) -> list[Any]:
    """Squared distances of knots to every edge, less the radius squared."""
    import casadi

    if task.free_space is None:
        return []
    rows = []
    for edge in task.free_space.boundary_segments:
        begin, along = casadi.DM(edge[:2]), edge[2:] - edge[:2]
        for agent, place in enumerate(places):
            offset = place[:, 1:-1] - casadi.repmat(begin, 1, KNOTS - 1)
            share = casadi.fmin(1, casadi.fmax(0, casadi.DM(along).T @ offset / (along @ along)))
            apart = offset - casadi.DM(along) @ share
            rows.append(casadi.sum1(apart**2) - float(task.radii[agent]) ** 2)
    return rows
