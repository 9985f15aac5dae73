"""Large-neighbourhood search on seeds: clear, cheaper, of different classes, repeatable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem, prepare
from stplan.problem.verification import verify
from stplan.seeding.elastic_bands.relaxation_seeder import Relaxation
from stplan.seeding.homotopy import signature
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.seed_improvement import (
    MOST_MOVES,
    cheapest_start,
    improve_seed,
    worthwhile_moves,
)
from stplan.seeding.seeder import Budget, SeedAttempt
from stplan.world import build_free_space


def levels_of(scene) -> Levels:
    return Levels(prepare(scene))


@pytest.fixture(scope="module")
def warehouse() -> tuple[Levels, SeedAttempt]:
    levels = levels_of(tight.warehouse(np.random.default_rng(5), robots=8))
    return levels, cheapest_start(levels, 2, Budget(1))


def cost(problem: PlanningProblem, attempt: SeedAttempt) -> float:
    return total_kinetic_cost(problem.masses, attempt.curves)


def test_seeds_get_cheaper_and_stay_clear(warehouse):
    levels, start = warehouse
    assert start.clear
    problem = levels.problem
    shortened = improve_seed(levels, start, 0, Budget())
    found = improve_seed(levels, start, 60, Budget(5))
    assert len(shortened) == 1
    assert cost(problem, found[0]) < 0.99 * cost(problem, shortened[0]) < cost(problem, start)
    assert all(one.clear and not verify(problem, one.curves) for one in found)
    assert found[0].tries == start.tries + 60


def test_classes_differ_and_the_cheapest_comes_first(warehouse):
    levels, start = warehouse
    found = improve_seed(levels, start, 60, Budget(5), keep=4)
    assert len(found) > 1
    labels = [signature(levels.problem, one.curves) for one in found]
    assert len(set(labels)) == len(labels)
    costs = [cost(levels.problem, one) for one in found]
    assert costs == sorted(costs)


def test_same_numbers_same_bytes(warehouse):
    levels, start = warehouse
    first, second, other = (
        improve_seed(levels, start, 20, Budget(rng_seed))[0].curves for rng_seed in (5, 5, 6)
    )
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, second, strict=True))
    assert any(a.tobytes() != b.tobytes() for a, b in zip(first, other, strict=True))


def test_out_of_time_the_start_comes_back_shortened(warehouse):
    levels, start = warehouse
    found = improve_seed(levels, start, 60, Budget(5, deadline=-np.inf))
    assert len(found) == 1
    assert found[0].tries == start.tries
    assert cost(levels.problem, found[0]) <= cost(levels.problem, start)


def test_the_cheapest_of_several_starts_is_taken(warehouse):
    levels, _ = warehouse
    single = [cheapest_start(levels, 1, Budget(number)) for number in (0, 1, 2)]
    best = cheapest_start(levels, 3, Budget(0))
    costs = [
        cost(levels.problem, improve_seed(levels, one, 0, Budget())[0])
        for one in single
        if one.clear
    ]
    assert cost(levels.problem, improve_seed(levels, best, 0, Budget())[0]) == pytest.approx(
        min(costs)
    )


def test_larger_scenes_are_worth_fewer_moves(warehouse):
    levels, _ = warehouse
    many = levels_of(tight.door(np.random.default_rng(1), per_side=20))
    assert 0 < worthwhile_moves(many) < worthwhile_moves(levels) <= MOST_MOVES


def test_what_is_not_clear_comes_back_as_it_is(warehouse):
    levels, _ = warehouse
    assert improve_seed(levels, SeedAttempt("nothing"), 5, Budget()) == [SeedAttempt("nothing")]


def test_curves_from_elsewhere_are_improved_too():
    scene = tight.pillars(np.random.default_rng(3), agents=6)
    levels = levels_of(scene)
    start = Relaxation(levels.problem).attempt(Budget())
    assert start.clear
    found = improve_seed(levels, start, 10, Budget())
    assert not verify(levels.problem, found[0].curves)


def test_prescribed_motion_stays_as_it_is():
    scene = tight.pillars(np.random.default_rng(3), agents=6)
    levels = levels_of(scene)
    start = cheapest_start(levels, 1, Budget())
    moved = replace(scene.agents[0], path=tuple(tuple(knot) for knot in start.curves[0].tolist()))
    fixed = replace(scene, agents=(moved, *scene.agents[1:]))
    levels = Levels(PlanningProblem.from_scene(fixed, build_free_space(fixed)))
    found = improve_seed(levels, start, 15, Budget())
    assert not verify(levels.problem, found[0].curves)
    assert found[0].curves[0].tobytes() == start.curves[0].tobytes()
