"""Multistart: seeds of different homotopy classes, of which the cheapest is optimised.

An optimisation keeps the homotopy class of its seed (who passes whom on which side), and classes differ in
cost by more than any option of the solver is worth. Among seeds that relaxation found, the cheapest seed
leads to the cheapest plan, so only one of them is optimised; docs/performance.md has the figures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stplan.analysis.metrics import turning
from stplan.certify.pair_clearance import nearest_moments
from stplan.compiled import working_time
from stplan.errors import SeedingError
from stplan.problem.kinetic import kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Seed, prepare_portfolio
from stplan.seeding.seeder import Budget

# `solver.starts: auto` makes so many starts for every pair an agent that would collide on straight ways:
# each of them doubles the classes there are. It makes no more than that in all, and fewer the more pairs of
# agents there are to relax: in large crowds the differences between classes even out.
STARTS_A_CONFLICT = 1.4
MOST_STARTS = 24
RELAXED_PAIRS = 15_000


def best_seed(problem: PlanningProblem, *, progress: Callable[[str], None]) -> Seed:
    """The cheapest of `solver.starts` seeds, found with `seeding.rng_seed` and the numbers after it.

    Each may take `seeding.time_limit`.

    Raises:
        SeedingError: the first start found none.
    """
    scene, settings = problem.scene, problem.scene.seeding
    deadline = working_time() + settings.time_limit
    portfolio = prepare_portfolio(problem)
    best = portfolio.find(Budget(settings.rng_seed, deadline, progress))
    starts = scene.solver.starts or _worthwhile_starts(problem, best)
    least, chosen = own_cost(scene, best.world_lines), 0
    for start in range(1, starts):
        deadline = working_time() + settings.time_limit
        try:
            seed = portfolio.find(Budget(settings.rng_seed + start, deadline))
        except SeedingError:
            continue
        cost = own_cost(scene, seed.world_lines)
        if cost < least:
            best, least, chosen = seed, cost, start
    if starts > 1:
        progress(f"start {chosen + 1} of {starts} is the cheapest")
    return replace(best, record=replace(best.record, starts=starts, start=chosen + 1))


def own_cost(scene: Scene, lines: WorldLines) -> float:
    """What single agents pay on `lines`: kinetic, acceleration and arrival cost."""
    total = 0.0
    for agent, curve in zip(scene.agents, lines.curves(), strict=True):
        weights = agent.weights
        total += weights.kinetic * kinetic_cost(agent.mass, curve)
        if weights.acceleration:
            total += weights.acceleration * turning(curve, scene.time_scale)
        if agent.preferred_time is not None:
            total += weights.arrival * 0.5 * (float(curve[-1, 2]) - agent.preferred_time) ** 2
    return total


def _worthwhile_starts(problem: PlanningProblem, first: Seed) -> int:
    """How many starts `auto` makes: search finds much the same seed every time."""
    count = problem.num_agents
    most = min(MOST_STARTS, RELAXED_PAIRS // max(count * (count - 1) // 2, 1))
    if first.found_by != "relaxation" or most <= 1:
        return 1
    return max(1, min(most, round(STARTS_A_CONFLICT * straight_conflicts(problem) / count)))


def straight_conflicts(problem: PlanningProblem) -> int:
    """Pairs that would collide if all went straight to their goals, as slowly as they may."""
    curves = [
        np.array([[*agent.start, agent.start_time], [*agent.goal, agent.max_time]])
        if path is None
        else path
        for agent, path in zip(problem.scene.agents, problem.paths, strict=True)
    ]
    leaves = np.array([curve[-1, 2] for curve in curves])
    lines = WorldLines.from_curves(problem.agent_ids, curves)
    found = nearest_moments(lines, leaves, problem.collides)
    needs = problem.distance[found.pairs[:, 0], found.pairs[:, 1]]
    return int((found.distance <= needs).sum())
