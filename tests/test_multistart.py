"""Multistart: how many are made, and that the cheapest is taken."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.multistart import EFFORTS, Contest, best_seeds, own_cost, straight_conflicts
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.model import Scene
from stplan.seeding.homotopy import signature
from stplan.world import build_free_space


def started(scene: Scene, starts: int | None = None, rng_seed: int = 0):
    scene = replace(
        scene,
        solver=replace(scene.solver, starts=starts),
        seeding=replace(scene.seeding, rng_seed=rng_seed),
    )
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    return best_seeds(problem, progress=lambda line: None).seeds[0]


def conflicts(scene: Scene) -> int:
    return straight_conflicts(PlanningProblem.from_scene(scene, None))


def test_all_pairs_of_a_circle_conflict_and_none_of_parallel_ways() -> None:
    assert conflicts(wide.circle(8, 8.0, 50.0)) == 28
    starts = np.column_stack([np.zeros(5), 3.0 * np.arange(5)])
    assert conflicts(wide.crowd(starts, starts + np.array([10.0, 0.0]), 20.0)) == 0


def test_the_cheapest_of_several_starts_is_taken() -> None:
    scene = wide.circle(8, 8.0, 50.0, radius=0.25)
    single = [started(scene, 1, rng_seed) for rng_seed in range(4)]
    costs = [own_cost(scene, seed.world_lines) for seed in single]
    best = started(scene, 4)
    assert own_cost(scene, best.world_lines) == min(costs) < max(costs)
    assert best.record.starts == 4
    assert best.record.start == 1 + int(np.argmin(costs))


def test_auto_makes_more_starts_where_more_pairs_conflict() -> None:
    few, many = (started(wide.circle(count, 8.0, 50.0, radius=0.25)) for count in (4, 10))
    assert 1 <= few.record.starts < many.record.starts


def tight_seeds(effort: str, starts: int | None = None):
    scene = tight.warehouse(np.random.default_rng(1), robots=4)
    scene = replace(scene, solver=replace(scene.solver, effort=effort, starts=starts))
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    contest = best_seeds(problem, progress=lambda line: None)
    return problem, contest.seeds[: contest.finalists]


def test_quick_effort_takes_the_first_seed() -> None:
    _, seeds = tight_seeds("quick")
    assert [seed.record.starts for seed in seeds] == [1]


def test_seeds_that_are_optimised_are_of_different_classes_the_cheapest_first() -> None:
    problem, seeds = tight_seeds("normal")
    assert 1 < len(seeds) <= 3
    costs = [own_cost(problem.scene, seed.world_lines) for seed in seeds]
    assert costs == sorted(costs)
    labels = {signature(problem, list(seed.world_lines.curves())) for seed in seeds}
    assert len(labels) == len(seeds)
    assert seeds[0].record.starts > len(seeds)


def test_a_number_of_starts_that_is_asked_for_is_made() -> None:
    _, seeds = tight_seeds("normal", starts=2)
    assert {seed.record.starts for seed in seeds} == {2}


@pytest.mark.parametrize(
    ("scene", "once"),
    [
        (wide.circle(4, 8.0, 50.0), "stplan.seeding.portfolio.hopeless"),
        (tight.door(np.random.default_rng(1), per_side=2), "stplan.seeding.search.roadmap.build_roadmap"),
    ],
)  # fmt: skip
def test_what_random_numbers_do_not_change_is_worked_out_once(
    scene: Scene, once: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    room, _, name = once.rpartition(".")
    work = getattr(import_module(room), name)
    calls = []

    def counted(*arguments: object, **named: object) -> object:
        calls.append(name)
        return work(*arguments, **named)

    monkeypatch.setattr(once, counted)
    assert started(scene, 1).record.starts == 1
    alone = len(calls)
    assert started(scene, 3).record.starts == 3
    assert len(calls) == 2 * alone > 0


@pytest.mark.parametrize("preferred", [None, 30.0])
def test_own_cost_counts_lateness(preferred: float | None) -> None:
    scene = wide.circle(2, 8.0, 50.0)
    seed = started(scene, 1)
    agents = tuple(
        replace(one, preferred_time=preferred, weights=replace(one.weights, arrival=2.0))
        for one in scene.agents
    )
    more = own_cost(replace(scene, agents=agents), seed.world_lines)
    late = [float(curve[-1, 2]) - (preferred or 0.0) for curve in seed.world_lines.curves()]
    expected = sum(gap**2 for gap in late) if preferred else 0.0
    assert more == pytest.approx(own_cost(scene, seed.world_lines) + expected)


def contest_of(scene: Scene, effort: str = "normal", **solver) -> Contest:
    scene = replace(scene, solver=replace(scene.solver, effort=effort, **solver))
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    return best_seeds(problem, progress=lambda line: None)


def test_where_few_agents_of_a_map_meet_others_compete_with_relaxation() -> None:
    scene = tight.plus_crossing(np.random.default_rng(2), turn=2)
    contest = contest_of(scene)
    assert contest.seeds[0].record.starts > 1
    assert contest.improvement > 0.0
    # Two pass each other on one side or the other: there is nothing more to look for.
    pair = contest_of(replace(scene, agents=scene.agents[:2]))
    assert (pair.seeds[0].record.starts, pair.improvement) == (1, 0.0)


def test_only_plans_between_walls_are_to_be_improved_the_longer_the_more_effort() -> None:
    scene = tight.cabin(np.random.default_rng(2), depth=1, passengers=4, rows=3)
    quick, normal = (contest_of(scene, effort).improvement for effort in ("quick", "normal"))
    assert 0.0 == quick < normal < EFFORTS["best"].improvement
    assert contest_of(scene, starts=2).improvement == 0.0
    assert contest_of(wide.circle(4, 4.0, 12.0)).improvement == 0.0
