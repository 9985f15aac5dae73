"""Multistart: seeds of different homotopy classes, of which the cheapest are optimised.

An optimisation keeps the homotopy class of its seed (who passes whom on which side), and classes differ in
cost by more than any option of the solver is worth. In the open, relaxation is started again and again; in
tight spaces other seeders compete with the first one that found a way. The cheapest seed mostly leads to the
cheapest plan; where it does not, one of the next two does (docs/performance.md has the figures), so in tight
spaces up to three seeds of different classes are optimised (`drafts.py` makes them).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stplan.analysis.own_costs import own_costs
from stplan.certify.pair_clearance import nearest_moments
from stplan.compiled import working_time
from stplan.drafts import tight_seeds
from stplan.errors import SeedingError
from stplan.problem.arrivals import hurried
from stplan.problem.launches import Launches
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.reasons import Reason
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Portfolio, Seed, prepare_portfolio
from stplan.seeding.seeder import Budget, Progress

# `solver.starts: auto` makes so many starts for every pair an agent that would collide on straight ways:
# each of them doubles the classes there are. It makes no more than that in all, and fewer the more pairs of
# agents there are to relax: in large crowds the differences between classes even out.
STARTS_A_CONFLICT = 1.4
MOST_STARTS = 24
RELAXED_PAIRS = 15_000


@dataclass(frozen=True)
class Effort:
    """How hard to look for a cheap plan.

    Attributes:
        starts_share: factor on the starts that a scene is worth.
        finalists: seeds that are optimised.
    """

    starts_share: float
    finalists: int


EFFORTS = {"quick": Effort(0.0, 1), "normal": Effort(1.0, 3), "best": Effort(4.0, 6)}
# Of more agents fewer seeds are optimised: classes differ less, and plans take longer.
AGENTS_A_FINALIST = 60


@dataclass(frozen=True)
class Contest:
    """Seeds of different classes, the cheapest first, and how many of them are worth optimising.

    The others are spares: what a scene asks of speeds and times may be out of reach in a cheaper class.
    """

    seeds: tuple[Seed, ...]
    finalists: int


def best_seeds(problem: PlanningProblem, *, progress: Progress) -> Contest:
    """Seeds to choose from.

    They come from `seeding.rng_seed` and the numbers after it. Each may take a `seeding.time_limit` of its
    own, so that one that is slow leaves the others as they are. Where nobody has a use for the horizon, an
    earlier one is tried first, for half the time.

    Raises:
        SeedingError: there is none; its reasons are in the user's units.
    """
    launches = None
    try:
        launches = Launches.of(problem)
        if launches is None:
            return _contest(problem, progress)
        contest = _contest(launches.problem, progress)
    except SeedingError as error:
        found = (
            error.reasons if launches is None else [_of_whole(launches, r) for r in error.reasons]
        )
        reasons = [problem.written.outside_reason(one) for one in found]
        raise SeedingError(reasons or str(error)) from error
    return replace(contest, seeds=tuple(_launched(launches, seed) for seed in contest.seeds))


def _launched(launches: Launches, seed: Seed) -> Seed:
    """A seed of the rest as one of all."""
    curves = launches.joined(list(seed.world_lines.curves()))
    return replace(seed, world_lines=WorldLines.from_curves(launches.whole.agent_ids, curves))


def _of_whole(launches: Launches, reason: Reason) -> Reason:
    """A reason why nothing was found for the rest as one of all: other launches may lead further."""
    agents = tuple(dict.fromkeys(map(launches.owner, reason.agents)))
    return replace(reason, agents=agents, proven=False)


def _contest(problem: PlanningProblem, progress: Progress) -> Contest:
    """Seeds within an earlier horizon where there is one and it leads to any, else within the scene's."""
    sooner = hurried(problem.scene)
    if sooner is None:
        return _best_seeds(problem, progress)
    limit, began = problem.scene.seeding.time_limit, working_time()
    early = np.array([agent.max_time for agent in sooner.agents])
    try:
        return _best_seeds(
            _limited(replace(problem, scene=sooner, max_times=early), 0.5 * limit), progress
        )
    except SeedingError:
        return _best_seeds(_limited(problem, limit - (working_time() - began)), progress)


def _limited(problem: PlanningProblem, limit: float) -> PlanningProblem:
    """`problem` with another `seeding.time_limit`, s."""
    seeding = replace(problem.scene.seeding, time_limit=limit)
    return replace(problem, scene=replace(problem.scene, seeding=seeding))


def _best_seeds(problem: PlanningProblem, progress: Progress) -> Contest:
    scene, settings = problem.scene, problem.scene.seeding
    portfolio = prepare_portfolio(problem)
    effort = EFFORTS[scene.solver.effort]
    budget = Budget(settings.rng_seed, working_time() + settings.time_limit, progress)
    if scene.minimise != "energy":
        # What competing seeds cost says nothing of arrivals.
        return Contest((portfolio.find(budget),), 1)
    if portfolio.rivals and scene.solver.starts is None and effort.starts_share > 0.0:
        most = max(1, min(effort.finalists, AGENTS_A_FINALIST // problem.num_agents))
        first = portfolio.first_clear(budget)
        return Contest(tight_seeds(problem, portfolio, first, effort.starts_share, most), most)
    every = list(_starts(problem, portfolio, budget, effort.starts_share))
    found = [
        replace(seed, record=replace(seed.record, starts=len(every), start=number))
        for number, seed in enumerate(every, start=1)
    ]
    # Sorting is stable: of equals the first one found comes first.
    found.sort(key=lambda seed: own_cost(scene, seed.world_lines))
    if len(found) > 1:
        best = found[0]
        progress(f"seed {best.record.start} of {len(found)} is the cheapest, by {best.found_by}")
    return Contest(tuple(found), 1)


def _starts(
    problem: PlanningProblem, portfolio: Portfolio, budget: Budget, share: float
) -> Iterator[Seed]:
    """The first seed, and those of as many other starts as were asked for, or as are worth it."""
    first = portfolio.find(budget)
    yield first
    asked, settings = problem.scene.solver.starts, problem.scene.seeding
    for start in range(1, asked or _worthwhile_starts(problem, first, share)):
        try:
            deadline = working_time() + settings.time_limit
            yield portfolio.find(Budget(settings.rng_seed + start, deadline))
        except SeedingError:
            continue


def own_cost(scene: Scene, lines: WorldLines) -> float:
    """What all agents pay on `lines`: kinetic, acceleration, arrival and grouping cost."""
    return float(own_costs(scene, lines).sum())


def _worthwhile_starts(problem: PlanningProblem, first: Seed, share: float) -> int:
    """How many starts `auto` makes in the open: search finds much the same seed every time."""
    count = problem.num_agents
    most = min(MOST_STARTS, RELAXED_PAIRS // max(count * (count - 1) // 2, 1))
    if first.found_by != "relaxation" or most <= 1:
        return 1
    worth = share * STARTS_A_CONFLICT * straight_conflicts(problem) / count
    return max(1, min(most, round(worth)))


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
