"""Drafts of seeds for tight spaces: who competes, until when, and that few are prepared."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.drafts import WALKS, tight_seeds
from stplan.errors import SeedingError
from stplan.multistart import own_cost
from stplan.problem.planning_problem import prepare
from stplan.problem.verification import verify
from stplan.seeding.homotopy import signature
from stplan.seeding.portfolio import Portfolio, Rival, prepare_portfolio
from stplan.seeding.seeder import Budget, SeedAttempt
from stplan.seeding.shortcutting.shortcuts import take_shortcuts


@dataclass
class Counted:
    """A seeder that gives one answer after another, the last one from then on."""

    answers: list[SeedAttempt]
    asked: int = 0

    def attempt(self, budget: Budget) -> SeedAttempt:
        self.asked += 1
        return self.answers[min(self.asked, len(self.answers)) - 1]


@pytest.fixture(scope="module")
def portfolio() -> Portfolio:
    return prepare_portfolio(prepare(tight.warehouse(np.random.default_rng(1), robots=5)))


@pytest.fixture(scope="module")
def first(portfolio) -> SeedAttempt:
    return portfolio.first_clear(Budget())


def seeds(
    portfolio: Portfolio, first: SeedAttempt, *rivals: Rival, share: float = 1.0, most: int = 3
):
    portfolio = replace(portfolio, rivals=rivals)
    return tight_seeds(portfolio.problem, portfolio, first, share, most, Budget())


def test_seeds_are_clear_of_different_classes_and_sorted(portfolio, first):
    problem = portfolio.problem
    found = tight_seeds(problem, portfolio, first, 1.0, 2, Budget())
    costs = [own_cost(problem.scene, seed.world_lines) for seed in found]
    assert 1 < len(found) <= 3
    assert costs == sorted(costs)
    assert costs[0] <= own_cost(problem.scene, portfolio.seed(first, Budget()).world_lines)
    assert len({signature(problem, list(seed.world_lines.curves())) for seed in found}) == len(
        found
    )
    assert not any(verify(problem, list(seed.world_lines.curves())) for seed in found)


def test_same_seeds_every_time(portfolio, first):
    one, two = (
        tight_seeds(portfolio.problem, portfolio, first, 1.0, 2, Budget()) for _ in range(2)
    )
    assert [seed.world_lines.knots.tobytes() for seed in one] == [
        seed.world_lines.knots.tobytes() for seed in two
    ]


def test_a_rival_that_fails_is_asked_no_more(portfolio, first):
    nothing = SeedAttempt("nothing")
    rival = Counted([nothing])
    patient = Counted([nothing, first, nothing])
    seeds(portfolio, first, Rival(rival, 8, patience=1), Rival(patient, 8, patience=2))
    assert rival.asked == 1
    # A success in between forgives what failed before.
    assert patient.asked == 4


def test_a_rival_that_is_far_too_dear_is_asked_no_more(portfolio, first, monkeypatch):
    cheap, dear = Counted([first]), Counted([replace(first, found_by="dear")])
    shortened = take_shortcuts

    def dearer(problem, curves, *options, **named):
        """What costs twice as much once shortened: the same ways in half the time."""
        curves = shortened(problem, curves, *options, **named)
        return [curve * [1.0, 1.0, 1.0 / 1.6] for curve in curves] if dear.asked else curves

    monkeypatch.setattr("stplan.drafts.take_shortcuts", dearer)
    rivals = [Rival(one, 3, patience=1) for one in (cheap, dear)]
    alone = replace(portfolio, rivals=rivals, levels=None)
    tight_seeds(portfolio.problem, alone, first, 1.0, 1, Budget())
    assert (cheap.asked, dear.asked) == (3, 1)


def test_where_there_is_no_room_nobody_else_is_asked(portfolio, first):
    jammed = Counted([SeedAttempt("no room", jammed=True)])
    other = Counted([first])
    found = seeds(portfolio, first, Rival(jammed, 8, patience=8), Rival(other, 8, patience=8))
    assert (jammed.asked, other.asked) == (1, 0)
    assert found


def test_no_share_asks_nobody(portfolio, first):
    rival = Counted([first])
    found = seeds(portfolio, first, Rival(rival, 8, patience=1), share=0.0)
    assert rival.asked == 0
    assert [seed.record.starts for seed in found] == [1]


def test_what_cannot_be_prepared_is_said(portfolio, first):
    late = Budget(deadline=-math.inf)
    with pytest.raises(SeedingError, match="not shortened and given their knots within"):
        tight_seeds(portfolio.problem, replace(portfolio, rivals=()), first, 0.0, 1, late)


def test_spare_seeders_are_asked_only_where_there_are_few_classes(portfolio, first, monkeypatch):
    monkeypatch.setattr("stplan.drafts.improve_seed", lambda *_arguments, **_options: [])
    others = [one.seeder for one in portfolio.rivals if not one.spare]
    spare = Counted([SeedAttempt("never")])
    rival = Rival(spare, 2, patience=1, spare=True)
    seeds(portfolio, first, rival)
    assert spare.asked == 1
    seeds(portfolio, first, Rival(others[0], 4, patience=1), Rival(others[1], 4, patience=1), rival)
    assert spare.asked == 1


def test_walks_begin_at_drafts_of_different_classes(portfolio, first, monkeypatch):
    begun = []

    def improve_seed(levels, start, moves, budget, *, keep):
        begun.append(signature(levels.problem, start.curves))
        return [start]

    monkeypatch.setattr("stplan.drafts.improve_seed", improve_seed)
    tight_seeds(portfolio.problem, portfolio, first, 1.0, 1, Budget())
    assert 1 < len(begun) <= WALKS
    assert len(set(begun)) == len(begun)
