"""The stages one after the other: what each hands on, and where planning can be stopped."""

from __future__ import annotations

import json
import signal
from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.own_costs import own_costs
from stplan.bench import families_tight as tight
from stplan.bench.families_open import agent, circle, scene
from stplan.certify.certificate import certify
from stplan.clock import Clock
from stplan.errors import BrokenSeedError, SolverError, StoppedError
from stplan.files.json_file import json_bytes
from stplan.improvement.budget import ImprovementBudget
from stplan.multistart import best_seeds
from stplan.optimize.whole import optimise_whole
from stplan.planner import (
    check,
    find_initial_curves,
    improve,
    plan,
    plan_files,
    prepare,
    seed,
    write_plan,
)
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.model import Scene, Visit
from stplan.status import Status


def limited() -> Scene:
    """Two agents who have to start and end at rest, which no seeder knows of."""
    one = agent("a", (0, 0), (9, 0), max_acceleration=0.3)
    other = agent("b", (4, 5), (4, -5), max_acceleration=0.3)
    return scene([one, other])


def test_every_stage_takes_what_the_one_before_gave() -> None:
    clear = circle(4, 4.0, 12.0)
    problem = prepare(clear)
    assert isinstance(problem, PlanningProblem)
    (initial,) = find_initial_curves(problem)
    found = best_seeds(problem, progress=lambda line: None).seeds[0]
    # Nothing is to be restored here.
    assert np.array_equal(initial.seed.world_lines.knots, found.world_lines.knots)
    assert np.array_equal(
        initial.world_lines.knots, problem.written.outside(found.world_lines).knots
    )
    assert initial.certificate == certify(clear, None, initial.world_lines)
    planned = plan(clear)
    assert np.array_equal(planned.seed.knots, initial.world_lines.knots)
    assert planned.trajectories is not None
    assert planned.certificate == check(clear, planned.trajectories)
    only = seed(clear)
    assert only.trajectories is None
    assert only.status is Status.SEEDED
    assert np.array_equal(only.seed.knots, planned.seed.knots)


def test_restoration_comes_between_the_seed_and_its_certificate() -> None:
    problem = prepare(limited())
    found = best_seeds(problem, progress=lambda line: None).seeds[0]
    assert not certify(problem.scene, None, found.world_lines).holds
    (initial,) = find_initial_curves(problem)
    assert initial.certificate.holds
    assert initial.seed.found_by == found.found_by
    assert initial.certificate == certify(limited(), None, initial.world_lines)


def test_what_restoration_does_not_reach_is_named() -> None:
    visits = (Visit(window=(5.0, 6.0), dwell=0.9),)
    crowded = scene(
        [
            agent("a", (0, 0), (9, 0), waypoints=((4.0, 0.0),), visits=visits),
            agent("b", (4, 5), (4, -5), waypoints=((4.0, 0.1),), visits=visits),
        ]
    )
    with pytest.raises(BrokenSeedError) as refused:
        find_initial_curves(prepare(crowded))
    assert refused.value.violations
    assert refused.value.exit_status == 3
    assert str(refused.value).startswith(
        "no initial curves were found that hold their certificate; of the best ones:\n  "
    )
    assert all(sentence in str(refused.value) for sentence in refused.value.violations[:5])


def test_stopped_before_the_limits_are_kept_there_is_nothing() -> None:
    with pytest.raises(StoppedError):
        plan(limited(), stop=lambda: True)


def test_stopped_later_there_is_a_plan_that_holds() -> None:
    planned = plan(circle(4, 4.0, 12.0), stop=lambda: True)
    assert planned.status is Status.INTERRUPTED
    assert planned.exit_status == 130
    assert planned.certificate.holds
    assert planned.trajectories is not None
    # The solver moves a start a hair off its bounds.
    assert np.allclose(planned.trajectories.knots, planned.seed.knots, rtol=0.0, atol=1e-6)


def used_up(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """Settings of a solver that may take one step a time."""
    del monkeypatch
    return {"max_iterations": 1}


def stuck(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """Settings of an Ipopt that gives up before its first step."""
    del monkeypatch
    return {"ipopt": {"max_wall_time": 1e-9}}


def displaced(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """An optimiser whose curves are wrong, and cheap."""

    def optimise(*arguments, **options):
        found = optimise_whole(*arguments, **options)
        knots = found.world_lines.knots + np.array([0.0, 0.1, 0.0])
        costs = dict.fromkeys(found.costs, 0.0)
        return replace(found, world_lines=found.world_lines.with_knots(knots), costs=costs)

    monkeypatch.setattr("stplan.planner.optimise_whole", optimise)
    return {}


@pytest.mark.parametrize(
    ("hindrance", "status", "exit_status"),
    [(used_up, Status.LIMIT, 0), (stuck, Status.FAILED, 4), (displaced, Status.BROKEN, 4)],
)
def test_however_it_ends_there_are_clear_curves_with_costs_of_their_own(
    hindrance, status, exit_status, monkeypatch
) -> None:
    clear = circle(3, 3.0, 12.0)
    solver = replace(clear.solver, outer_iterations=2, **hindrance(monkeypatch))
    planned = plan(replace(clear, solver=solver))
    assert planned.status is status
    assert planned.exit_status == exit_status
    assert planned.advice
    assert planned.certificate.holds
    assert planned.trajectories is not None
    assert planned.certificate == check(clear, planned.trajectories)
    # The solver moves a start a hair off its bounds.
    moved = np.abs(planned.trajectories.knots - planned.seed.knots).max()
    assert moved > 1e-3 if status is Status.LIMIT else moved < 1e-6
    content = json.loads(json_bytes(planned.report.as_dict()))
    assert content["status"] == status
    masses = [one.mass for one in clear.agents]
    kinetic = total_kinetic_cost(masses, planned.trajectories.curves())
    assert content["costs"]["kinetic"] == pytest.approx(kinetic)
    assert None not in content["costs"].values()
    assert all(done["objective"] is not None for done in content["outer_iterations"])


def test_the_callback_is_asked_as_soon_as_there_is_something_to_keep(monkeypatch) -> None:
    happened = []

    def stop() -> bool:
        happened.append("asked")
        return True

    from stplan import planner

    real = planner.optimise_whole

    def optimise(*arguments, **options):
        happened.append("optimise")
        return real(*arguments, **options)

    monkeypatch.setattr(planner, "optimise_whole", optimise)
    plan(circle(3, 3.0, 12.0), stop=stop)
    # So that whoever stops by signals knows that none is lost from here on.
    assert happened[:3] == ["asked", "optimise", "asked"]


@pytest.mark.parametrize("command", [plan, seed])
def test_options_that_ipopt_does_not_know_are_refused_before_any_work(command, monkeypatch) -> None:
    monkeypatch.setattr("stplan.planner.best_seeds", None)
    asked = circle(3, 3.0, 12.0)
    for options in ({"no_such_option": 1}, {"mu_strategy": "bogus"}, {"tol": "small"}):
        other = replace(asked, solver=replace(asked.solver, ipopt=options))
        with pytest.raises(SolverError, match=rf"solver\.ipopt\.{next(iter(options))}"):
            command(other)


def test_files_of_a_seed_lack_trajectories() -> None:
    names = set(plan_files(seed(circle(3, 3.0, 12.0))))
    assert names == {"seed.csv", "seed.npz", "report.json", "run.json"}


def test_no_handler_of_a_signal_is_touched(tmp_path, monkeypatch) -> None:
    def refuse(*arguments):
        raise AssertionError("the library installs a handler")

    monkeypatch.setattr(signal, "signal", refuse)
    write_plan(plan(circle(3, 3.0, 12.0)), tmp_path / "run")
    assert (tmp_path / "run" / "run.json").exists()


def test_stages_add_up() -> None:
    clock = Clock()
    for name in ("seed", "certify", "seed"):
        with clock.stage(name):
            pass
    assert list(clock.seconds) == ["seed", "certify"]
    assert min(clock.seconds.values()) > 0
    assert clock.total >= sum(clock.seconds.values())


def test_plans_between_walls_are_improved_by_a_counted_effort_and_never_dearer() -> None:
    given = tight.plus_crossing(np.random.default_rng(1), turn=2)
    given = replace(given, solver=replace(given.solver, knots=20))
    first, again = plan(given), plan(given)
    record = first.report.improvement
    assert record is not None
    assert record.moves > 1
    assert record.cost_after <= record.cost_before
    assert record.cost_after == pytest.approx(own_costs(first.scene, first.trajectories).sum())
    assert first.certificate.holds
    assert record == again.report.improvement
    assert first.trajectories.knots.tolist() == again.trajectories.knots.tolist()
    # What is asked for afterwards tries other moves.
    later = improve(first, ImprovementBudget(moves=1)).report.improvement
    assert (later.moves, later.cost_before) == (1, record.cost_after)
    quick = replace(given, solver=replace(given.solver, effort="quick"))
    assert plan(quick).report.improvement is None
