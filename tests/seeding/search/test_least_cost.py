"""Prioritised planning by cost: cheaper than by time, clear, repeatable."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.planner import prepare
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.seeding.search.least_cost import LeastCost
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.schedule import Search
from stplan.seeding.seeder import Budget


@pytest.fixture(scope="module")
def problem() -> PlanningProblem:
    return prepare(tight.warehouse(np.random.default_rng(3), robots=8))


def test_its_curves_are_clear_and_cheaper_than_the_earliest_ones(problem: PlanningProblem) -> None:
    levels = Levels(problem)
    cheap, early = LeastCost(levels).attempt(Budget()), Search(levels).attempt(Budget())
    assert cheap.clear
    assert not verify(problem, cheap.curves)
    masses = problem.masses
    assert total_kinetic_cost(masses, cheap.curves) < total_kinetic_cost(masses, early.curves)


def test_the_same_random_number_gives_the_same_curves(problem: PlanningProblem) -> None:
    first, again, other = (
        LeastCost(Levels(problem)).attempt(Budget(rng_seed)).curves for rng_seed in (1, 1, 3)
    )
    assert all((a == b).all() for a, b in zip(first, again, strict=True))
    assert any(a.shape != b.shape or (a != b).any() for a, b in zip(first, other, strict=True))


def test_larger_scenes_are_worth_fewer_starts(problem: PlanningProblem) -> None:
    few = prepare(tight.warehouse(np.random.default_rng(3), robots=24))
    assert LeastCost(Levels(few)).worthwhile_starts < LeastCost(Levels(problem)).worthwhile_starts


def test_where_nobody_fits_it_says_so() -> None:
    scene = tight.plus_crossing(np.random.default_rng(1), turn=3)
    found = LeastCost(Levels(prepare(scene))).attempt(Budget(deadline=-1.0))
    assert not found.clear


def test_either_cost_gives_clear_curves_of_its_own(problem: PlanningProblem) -> None:
    levels = Levels(problem)
    by_motion = LeastCost(levels).attempt(Budget())
    by_length = LeastCost(levels, by_length=True).attempt(Budget())
    assert by_motion.clear
    assert by_length.clear
    lengths = [
        sum(float(np.hypot(*np.diff(curve[:, :2], axis=0).T).sum()) for curve in found.curves)
        for found in (by_motion, by_length)
    ]
    assert lengths[1] != lengths[0]


def test_moves_just_as_far_off_the_walls_as_required_spoil_nothing() -> None:
    # An edge of this roadmap is so near to the required distance that rounding decides.
    problem = prepare(tight.pillars(np.random.default_rng(101), agents=16))
    found = LeastCost(Levels(problem)).attempt(Budget())
    assert found.clear
    assert found.tries == 1
