"""Plans as fast as can be: curves optimised again and again for their arrivals, until these get no earlier.

Weights of barriers follow what agents pay on their seed; as arrivals become earlier they are too strong. So
what was optimised is the seed of another pass, with weights of its own, as long as that is worth it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stplan.analysis.shortest_trips import shortest_duration, shortest_legs
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop
from stplan.optimize.continuation import LiveLine, Optimisation
from stplan.optimize.whole import optimise_whole
from stplan.problem.planning_problem import PlanningProblem, at_horizon
from stplan.problem.world_lines import WorldLines
from stplan.scene.horizon import ample_horizon
from stplan.scene.model import Objective
from stplan.status import Status

# A pass is worth another one where arrivals became earlier by this share.
WORTHWHILE = 0.01
# By `solver.effort`.
MOST_PASSES = {"quick": 2, "normal": 8, "best": 24}


def hasten(
    problem: PlanningProblem,
    seed: WorldLines,
    *,
    progress: Progress,
    stop: Stop,
    live: LiveLine | None = None,
) -> Optimisation:
    """Make the arrivals of `seed` early, as the scene asks.

    Raises:
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """

    def late(lines: WorldLines) -> float:
        return lateness(problem.scene.minimise, problem.start_times, arrivals_of(lines))

    done = optimise_whole(problem, seed, progress=progress, live=live, stop=stop)
    before = late(seed)
    for number in range(1, MOST_PASSES[problem.scene.solver.effort] + 1):
        lines, now = done.world_lines, late(done.world_lines)
        progress(f"pass {number}: {_said(problem, lines)}")
        ended = done.status in (Status.FAILED, Status.INTERRUPTED)
        if ended or before - now <= WORTHWHILE * before or stop():
            break
        before = now
        again = optimise_whole(problem, lines, progress=progress, live=live, stop=stop)
        done = _joined(done, again)
    return done


def arrivals_of(lines: WorldLines) -> FloatArray:
    """(A,) when everybody arrives, s."""
    return np.asarray(lines.knots[lines.offsets[1:] - 1, 2])


def lateness(objective: Objective, starts: FloatArray, arrivals: FloatArray) -> float:
    """What is to be least, s: until the last has arrived, or what all take from their `starts` together."""
    if objective == "makespan":
        return float(arrivals.max() - starts.min())
    return float((arrivals - starts).sum())


def _said(problem: PlanningProblem, lines: WorldLines) -> str:
    arrivals = problem.frame.times(arrivals_of(lines))
    return f"all there after {arrivals.max():.2f} s, on average after {arrivals.mean():.2f} s"


def _joined(first: Optimisation, second: Optimisation) -> Optimisation:
    """Both one after the other as one."""
    count = len(first.outer_iterations)
    later = tuple(replace(outer, number=outer.number + count) for outer in second.outer_iterations)
    failed = second.status is Status.FAILED
    return replace(
        second,
        status=first.status if failed else second.status,
        outer_iterations=first.outer_iterations + later,
        seed_costs=first.seed_costs,
        seed_scales=first.seed_scales,
        iterations=first.iterations + second.iterations,
        nonzeros=max(first.nonzeros, second.nonzeros),
    )


def with_ample_horizon(problem: PlanningProblem) -> PlanningProblem:
    """`problem`, whose horizon is open, with one that suits the agents' shortest ways."""
    durations = [
        0.0 if agent.path is not None else shortest_duration(agent, legs)
        for agent, legs in zip(problem.scene.agents, shortest_legs(problem), strict=True)
    ]
    ample = ample_horizon(problem.scene, durations)
    return at_horizon(problem, float(problem.frame.times(np.array([ample]))[0]))
