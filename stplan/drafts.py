"""Seeds for tight spaces: many drafts, of which the cheapest are improved and few are prepared.

A draft is what one start of a seeder found, shortened a little: enough to tell what it will cost. Seeders
differ more than their starts do, so all rivals of the portfolio are asked; one whose drafts fail or cost far
more than the best is asked no more, and nobody is once one has found that there is no room. The cheapest
drafts are then improved by large-neighbourhood search, and only the cheapest of different homotopy classes
are tightened and given their knots.

All efforts are counted. The time limit is the only clock: a draft that is not made in time is not made at
all, and some of the limit is kept for the preparation of those that are.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from stplan.analysis.own_costs import own_costs
from stplan.deadline import OutOfTimeError, until
from stplan.errors import SeedingError
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import held_requirement
from stplan.problem.world_lines import WorldLines
from stplan.seeding.homotopy import signature
from stplan.seeding.portfolio import Portfolio, Rival, Seed, attempted
from stplan.seeding.search.seed_improvement import ROUNDS, improve_seed, worthwhile_moves
from stplan.seeding.seeder import Budget, SeedAttempt
from stplan.seeding.shortcutting.shortcuts import take_shortcuts

# A draft that costs so many times the cheapest one counts as a failure.
OUTCLASSED = 1.5
# A failure counts as one more for so many sweeps that it took.
SWEEPS_A_FAILURE = 200
# The cheapest drafts of different classes that are improved: where a walk ends is much a matter of luck.
WALKS = 3
# States of an improved draft that compete with the others.
IMPROVED = 3
# Seeds prepared beyond those that are optimised: preparing changes who is cheapest.
SPARES = 1
# Share of the time limit that is left to those who compete: the rest is for the preparation.
COMPETITION = 0.8


@dataclass(frozen=True)
class Draft:
    """Clear curves of one start, shortened a little.

    Attributes:
        start: which start they come from, from 1.
        rng_seed: of that start.
        cost: of all agents by themselves, J s.
    """

    attempt: SeedAttempt
    start: int
    rng_seed: int
    cost: float


def tight_seeds(
    problem: PlanningProblem,
    portfolio: Portfolio,
    first: SeedAttempt,
    share: float,
    most: int,
    budget: Budget,
) -> tuple[Seed, ...]:
    """Seeds of different classes, the cheapest first, all that `first` and its rivals lead to.

    Args:
        problem: as the scene has it; the portfolio's may have a smaller map.
        share: factor on the starts and moves that the scene is worth.
        most: how many will be optimised.
        budget: with the deadline of all of it.

    Raises:
        SeedingError: none could be prepared.
    """
    maker = _Drafts(problem, portfolio, competing(problem, budget))
    drafts = [maker.draft(first, budget.rng_seed)]
    for rival in portfolio.rivals:
        if maker.jammed:
            break
        if rival.spare and len(_distinct(problem, drafts)) >= WALKS:
            continue
        drafts += maker.compete(rival, share, min(draft.cost for draft in drafts))
    for begin in _distinct(problem, sorted(drafts, key=_cost))[:WALKS]:
        drafts += maker.improved(begin, share)
    distinct = _distinct(problem, sorted(drafts, key=_cost))
    return maker.prepared(distinct, most + SPARES, budget.deadline)


def competing(problem: PlanningProblem, budget: Budget) -> Budget:
    """`budget` for seeds that compete with the first one: of the limit some is left when they end."""
    kept = (1.0 - COMPETITION) * problem.scene.seeding.time_limit
    return replace(budget, deadline=budget.deadline - kept)


class _Drafts:
    """Makes drafts and seeds of them.

    Attributes:
        jammed: whether a rival was given up because nobody has room.
    """

    def __init__(self, problem: PlanningProblem, portfolio: Portfolio, budget: Budget) -> None:
        self._problem = problem
        self._portfolio = portfolio
        self._budget = budget
        self._starts = 0
        self.jammed = False

    def draft(self, found: SeedAttempt, rng_seed: int) -> Draft:
        """The draft of another start."""
        self._starts += 1
        return self._shortened(found, self._starts, rng_seed)

    def compete(self, rival: Rival, share: float, best: float) -> Iterator[Draft]:
        """Drafts of a rival, as long as it does not fail, and costs about as little as the `best`."""
        failures = 0.0
        rng_seed = self._budget.rng_seed + rival.spare
        for start in range(round(share * rival.starts)):
            if failures >= rival.patience or self._budget.spent():
                break
            found = attempted(rival.seeder, replace(self._budget, rng_seed=rng_seed + start))
            self.jammed = found.jammed
            if self.jammed:
                break
            failures += 1.0 + (found.record.sweeps or 0) / SWEEPS_A_FAILURE
            if found.clear:
                draft = self.draft(found, rng_seed + start)
                best = min(best, draft.cost)
                failures = failures if draft.cost > OUTCLASSED * best else 0.0
                yield draft

    def improved(self, draft: Draft, share: float) -> list[Draft]:
        """The cheapest states of different classes that large-neighbourhood search leads to."""
        levels = self._portfolio.levels
        moves = 0 if levels is None else round(share * worthwhile_moves(levels))
        if levels is None or not moves or self._budget.spent():
            return []
        budget = replace(self._budget, rng_seed=draft.rng_seed)
        with until(budget.deadline):
            try:
                found = improve_seed(levels, draft.attempt, moves, budget, keep=IMPROVED)
            except OutOfTimeError:
                return []
        return [
            self._shortened(one, draft.start, draft.rng_seed)
            for one in found
            if one is not draft.attempt
        ]

    def prepared(self, drafts: Iterable[Draft], most: int, deadline: float) -> tuple[Seed, ...]:
        """Up to `most` of the drafts as seeds of different classes, the cheapest first."""
        seeds: dict[bytes, Seed] = {}
        failed: SeedingError | None = None
        for draft in drafts:
            budget = replace(self._budget, rng_seed=draft.rng_seed, deadline=deadline)
            if len(seeds) == most or ((seeds or failed) and budget.spent()):
                break
            try:
                seed = self._portfolio.seed(draft.attempt, budget)
            except SeedingError as error:
                failed = failed or error
                continue
            record = replace(seed.record, starts=self._starts, start=draft.start)
            # Tightening may take curves to the class of others.
            label = signature(self._problem, list(seed.world_lines.curves()))
            seeds.setdefault(label, replace(seed, record=record))
        if failed is not None and not seeds:
            raise failed
        return tuple(sorted(seeds.values(), key=lambda seed: self._own_cost(seed.world_lines)))

    def _shortened(self, found: SeedAttempt, start: int, rng_seed: int) -> Draft:
        """As far as time allows: shortened for all rounds or not at all."""
        problem, required = self._portfolio.problem, self._portfolio.required
        held = held_requirement(problem, found.curves, required)
        with until(self._budget.deadline):
            curves = take_shortcuts(problem, found.curves, held, rng_seed=rng_seed, rounds=ROUNDS)
        if self._budget.spent():
            curves = found.curves
        lines = WorldLines.from_curves(problem.agent_ids, curves)
        return Draft(replace(found, curves=curves), start, rng_seed, self._own_cost(lines))

    def _own_cost(self, lines: WorldLines) -> float:
        return float(own_costs(self._problem.scene, lines).sum())


def _cost(draft: Draft) -> float:
    return draft.cost


def _distinct(problem: PlanningProblem, drafts: Iterable[Draft]) -> list[Draft]:
    """The first draft of every class."""
    chosen: dict[bytes, Draft] = {}
    for draft in drafts:
        chosen.setdefault(signature(problem, draft.attempt.curves), draft)
    return list(chosen.values())
