"""Initial curves where time is short: found with more of it, then made to arrive earlier.

Seeding looks for curves that are clear within the time there is, whatever the limits of motion. Where these
cannot be kept on any of them, too much happens too fast. With more time limits are no trouble; from curves
that keep them the optimiser of early arrivals goes back to the time there is: it never gives up a limit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stplan.callbacks import Progress, Stop
from stplan.compiled import working_time
from stplan.errors import SeedingError
from stplan.hastening import arrivals_of
from stplan.multistart import best_seeds
from stplan.optimize.restoration import restore
from stplan.optimize.whole import optimise_whole
from stplan.problem.metric import sharpened
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.portfolio import Seed

# Everybody gets so many times the time it has.
MORE_TIME = (2.0, 4.0)
# A pass is worth another one where arrivals became earlier by this share; and how many there are at most.
WORTHWHILE, MOST_PASSES = 0.01, 6


def punctual_seeds(
    problem: PlanningProblem, deadline: float, *, progress: Progress, stop: Stop
) -> Iterator[Seed]:
    """Seeds of `problem` found with more time, as far as they can be made to arrive in time.

    Whether they keep all that the scene asks is for the certificate to say. Nothing is looked for after
    `deadline`, s of `working_time`.
    """
    movers = [agent for agent in problem.scene.agents if agent.path is None]
    if any(agent.max_speed is None for agent in movers):
        # Whoever may go at any speed is not hastened.
        return
    for more in MORE_TIME:
        left = deadline - working_time()
        if left <= 0.0 or stop():
            return
        progress(f"looking for curves in {more:g} times the time there is")
        ample = _with_more_time(problem, more, left)
        try:
            contest = best_seeds(ample, progress=progress)
        except SeedingError:
            continue
        for seed in contest.seeds:
            found = _in_time(problem, ample, seed, progress=progress, stop=stop)
            if found is not None:
                yield found


def _with_more_time(problem: PlanningProblem, more: float, time_limit: float) -> PlanningProblem:
    """`problem` with later latest arrivals; what is to be least is their sum."""
    agents = tuple(
        replace(agent, max_time=agent.start_time + more * (agent.max_time - agent.start_time))
        if agent.path is None
        else agent
        for agent in problem.scene.agents
    )
    max_times = np.array([agent.max_time for agent in agents], dtype=np.float64)
    scene = replace(
        problem.scene,
        agents=agents,
        horizon=max(problem.scene.horizon, float(max_times.max())),
        minimise="arrivals",
        seeding=replace(problem.scene.seeding, time_limit=time_limit),
    )
    return replace(problem, scene=scene, max_times=max_times)


def _in_time(
    problem: PlanningProblem,
    ample: PlanningProblem,
    seed: Seed,
    *,
    progress: Progress,
    stop: Stop,
) -> Seed | None:
    """`seed` of the `ample` problem as one of `problem`; None where somebody comes too late."""
    lines = restore(ample, seed.world_lines, seed.rendezvous, progress=progress, stop=stop)
    before = np.inf
    for _ in range(MOST_PASSES):
        late = arrivals_of(lines) - problem.max_times
        if (late <= 0.0).all():
            return replace(seed, world_lines=lines)
        total = float((arrivals_of(lines) - problem.start_times).sum())
        if stop() or total >= (1.0 - WORTHWHILE) * before:
            return None
        before = total
        sharp = sharpened(ample, lines)
        lines = optimise_whole(sharp, lines, progress=progress, stop=stop).world_lines
    return None
