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
from stplan.callbacks import Progress
from stplan.certify.pair_clearance import nearest_moments
from stplan.compiled import working_time
from stplan.drafts import competing, tight_seeds
from stplan.errors import SeedingError
from stplan.problem.arrivals import sooner_horizon
from stplan.problem.launches import Launches
from stplan.problem.planning_problem import PlanningProblem, within
from stplan.problem.world_lines import WorldLines
from stplan.reasons import Reason
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Portfolio, Seed, prepare_portfolio
from stplan.seeding.seeder import Budget

# `solver.starts: auto` makes so many starts for every pair an agent that would collide on straight ways:
# each of them doubles the classes there are. It makes no more than that in all, and fewer the more pairs of
# agents there are to relax: in large crowds the differences between classes even out.
STARTS_A_CONFLICT = 1.4
MOST_STARTS = 24
RELAXED_PAIRS = 15_000
# Of so few agents in a map searches compete with relaxation where straight ways are clear of its walls, too:
# they let agents give way in time where there is little space, and take no long time.
FEW_IN_A_MAP = 8
# So many agents pass each other on one side or the other: there is nothing more to look for.
PAIR = 2
# Share of the time limit for an earlier horizon.
HASTE = 0.5


@dataclass(frozen=True)
class Effort:
    """How hard to look for a cheap plan.

    Attributes:
        starts_share: factor on the starts that a scene is worth.
        finalists: seeds that are optimised.
        improvement: what the cheapest plan is improved for between walls, as `ImprovementBudget.effort`.
    """

    starts_share: float
    finalists: int
    improvement: float


EFFORTS = {
    "quick": Effort(0.0, 1, 0.0),
    "normal": Effort(1.0, 3, 300.0),
    "best": Effort(4.0, 6, 2000.0),
}
# Of more agents fewer seeds are optimised: classes differ less, and plans take longer.
AGENTS_A_FINALIST = 60
# The cheapest plan is improved for less where agents are fewer, and seeds are soon found, or more, and
# iterations take long; not at all where classes differ little.
FEW_AGENTS, MANY_AGENTS, CROWD = 8, 20, 60


@dataclass(frozen=True)
class Contest:
    """Seeds of different classes, the cheapest first, and how many of them are worth optimising.

    The others are spares: what a scene asks of speeds and times may be out of reach in a cheaper class.
    `horizon` is the earlier one within which all were found, s; None where it is the scene's. `improvement`
    is what the cheapest plan is to be improved for, as `ImprovementBudget.effort`.
    """

    seeds: tuple[Seed, ...]
    finalists: int
    horizon: float | None = None
    improvement: float = 0.0


def best_seeds(problem: PlanningProblem, *, progress: Progress) -> Contest:
    """Seeds to choose from.

    They come from `seeding.rng_seed` and the numbers after it. All of them share `seeding.time_limit`: what
    is found by then competes. Where nobody has a use for the horizon, an earlier one is tried first, for
    half the time.

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
    sooner = sooner_horizon(problem.scene)
    limit, began = problem.scene.seeding.time_limit, working_time()
    budget = Budget(problem.scene.seeding.rng_seed, began + limit, progress)
    if sooner is None:
        return _best_seeds(problem, budget, budget.deadline)
    try:
        contest = _best_seeds(within(problem, sooner), budget, began + HASTE * limit)
        return replace(contest, horizon=sooner)
    except SeedingError:
        return _best_seeds(problem, budget, budget.deadline)


def _best_seeds(problem: PlanningProblem, budget: Budget, first_deadline: float) -> Contest:
    """Seeds of `problem`: the first found by `first_deadline` (s of `working_time`), all by the budget's."""
    scene, progress = problem.scene, budget.progress
    early = replace(budget, deadline=first_deadline)
    portfolio = prepare_portfolio(problem, first_deadline, contested=_contested(problem))
    effort = EFFORTS[scene.solver.effort]
    if scene.minimise != "energy":
        # What competing seeds cost says nothing of arrivals.
        return Contest((portfolio.find(early),), 1)
    if portfolio.rivals and scene.solver.starts is None and effort.starts_share > 0.0:
        most = max(1, min(effort.finalists, AGENTS_A_FINALIST // problem.num_agents))
        first = portfolio.first_clear(early)
        seeds = tight_seeds(problem, portfolio, first, effort.starts_share, most, budget)
        return Contest(seeds, most, improvement=_worthwhile_improvement(problem.num_agents, effort))
    seed = portfolio.find(early)
    others = competing(problem, budget)
    every = [seed, *_starts(problem, portfolio, seed, others, effort.starts_share)]
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


def _contested(problem: PlanningProblem) -> bool:
    """Whether few agents of a map, but more than two, are in each other's way."""
    few = problem.free_space is not None and PAIR < problem.num_agents <= FEW_IN_A_MAP
    return few and straight_conflicts(problem) > 0


def _starts(
    problem: PlanningProblem, portfolio: Portfolio, first: Seed, budget: Budget, share: float
) -> Iterator[Seed]:
    """Seeds of as many starts besides the first as were asked for, or as are worth it."""
    asked = problem.scene.solver.starts
    for start in range(1, asked or _worthwhile_starts(problem, first, share)):
        if budget.spent():
            break
        try:
            yield portfolio.find(Budget(budget.rng_seed + start, budget.deadline))
        except SeedingError:
            continue


def _worthwhile_improvement(num_agents: int, effort: Effort) -> float:
    """What the cheapest plan of so many agents is improved for."""
    if not PAIR < num_agents <= CROWD:
        return 0.0
    return effort.improvement * min(num_agents / FEW_AGENTS, 1.0, MANY_AGENTS / num_agents)


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
