"""Trials of rivals: dear ones are given up early, others come to what a whole optimisation comes to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.certify.certificate import certify
from stplan.improvement.trials import SHORT_ITERATIONS, Trials
from stplan.optimize.continuation import optimise
from stplan.planner import find_initial_curves
from stplan.problem.planning_problem import prepare


@pytest.fixture(scope="module")
def seeded():
    scene = tight.plus_crossing(np.random.default_rng(1), turn=2)
    problem = prepare(replace(scene, solver=replace(scene.solver, knots=20, starts=1)))
    (initial,) = find_initial_curves(problem)
    return problem, initial.seed.world_lines


def trials(seeded, stop=lambda: False) -> Trials:
    return Trials(seeded[0], stop)


def test_a_trial_comes_to_what_an_optimisation_comes_to(seeded):
    problem, lines = seeded
    trial = trials(seeded)
    whole = optimise(problem, lines, progress=lambda line: None, stop=lambda: False).world_lines
    short = trial.shortly(lines, np.inf)
    assert 0 < trial.iterations <= SHORT_ITERATIONS
    full = trial.fully(short).world_lines
    assert trial.cost(full) == pytest.approx(trial.cost(whole), rel=0.01)
    assert trial.cost(full) < trial.cost(short) < trial.cost(lines)
    assert certify(problem.scene, problem.free_space, full).holds


def test_much_dearer_curves_are_given_up(seeded):
    _, lines = seeded
    trial = trials(seeded)
    cost = trial.cost(trial.shortly(lines, np.inf))
    assert trial.shortly(lines, cost / 1.02) is not None
    assert trial.shortly(lines, cost / 1.04) is None


def test_a_stopped_trial_is_given_up(seeded):
    _, lines = seeded
    assert trials(seeded, lambda: True).shortly(lines, np.inf) is None
