"""Rivals of a plan: dear ones are given up after an outer iteration, others optimised as anything else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.optimize.continuation import optimise
from stplan.optimize.rivals import SCREEN, optimise_rival
from stplan.planner import find_initial_curves
from stplan.problem.planning_problem import prepare


@pytest.fixture(scope="module")
def problem():
    scene = tight.plus_crossing(np.random.default_rng(1), turn=2)
    return prepare(replace(scene, solver=replace(scene.solver, knots=20, starts=1)))


@pytest.fixture(scope="module")
def seed(problem):
    (initial,) = find_initial_curves(problem)
    return initial.seed.world_lines


def going_on():
    return False


@pytest.fixture(scope="module")
def alone(problem, seed):
    return optimise(problem, seed, progress=lambda line: None, stop=going_on)


def objectives(found) -> list[float]:
    return [done.objective for done in found.outer_iterations]


def test_a_rival_that_is_as_good_comes_to_what_it_comes_to_alone(problem, seed, alone):
    for known in ([], [objectives(alone)], [[1e9, *objectives(alone)]]):
        found = optimise_rival(problem, seed, known, stop=going_on)
        assert found is not None
        np.testing.assert_array_equal(found.world_lines.knots, alone.world_lines.knots)


@pytest.mark.parametrize("late", [0, 2])
def test_a_rival_is_given_up_once_it_is_dear(problem, seed, alone, late):
    known = objectives(alone)
    known[late] /= 1.01 * SCREEN
    assert optimise_rival(problem, seed, [objectives(alone), known], stop=going_on) is None


def test_what_happens_after_the_last_outer_iteration_gives_nothing_up(problem, seed, alone):
    known = [*objectives(alone)[:-1], 0.0]
    assert optimise_rival(problem, seed, [known], stop=going_on) is not None


def test_a_rival_that_is_stopped_is_given_up(problem, seed):
    assert optimise_rival(problem, seed, [], stop=lambda: True) is None


def test_an_optimisation_ends_where_it_is_not_worth_going_on(problem, seed, alone):
    asked = []

    def proceed(objective: float, left: int) -> bool:
        asked.append((objective, left))
        return left > 3

    found = optimise(problem, seed, progress=lambda line: None, stop=going_on, proceed=proceed)
    total = problem.scene.solver.outer_iterations
    assert asked == [
        (value, total - 1 - n) for n, value in enumerate(objectives(alone)[: total - 3])
    ]
    assert len(found.outer_iterations) == total - 3
