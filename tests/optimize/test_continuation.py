"""The outer loop: what it minimises at every evaluation, what programs hand on, how it ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import yaml

import stplan
from stplan.bench.families_open import circle
from stplan.certify.certificate import certify
from stplan.nlp.backend import Backend
from stplan.nlp.step_control import StepControl
from stplan.optimize.assembly import formulate
from stplan.optimize.continuation import Optimisation, ipopt, optimise
from stplan.optimize.convergence import REBUILD_EVERY
from stplan.optimize.cost_scales import CostScales
from stplan.planner import Plan, find_initial_curves
from stplan.problem.planning_problem import prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import load_scene, parse_scene
from stplan.scene.model import Scene
from stplan.status import Status
from tests.claims.plans import SCENES
from tests.optimize.recomputed import BruteForce
from tests.optimize.scenes import FAST, FRIENDS, MEET, ROOM, scene_text
from tests.optimize.watched import Audit, Failing

CLOSE_FRIENDS = "pairs: [{between: [sam, eve], grouping: 5.0}]"
SMOOTH = "clearance_model: smooth-minimum"
VARIANTS: dict[str, dict[str, Any]] = {
    "open": {},
    "walls": {"map": ROOM},
    "friends among walls": {"map": ROOM, "pairs": FRIENDS},
    "close friends": {"map": ROOM, "pairs": CLOSE_FRIENDS},
    "meeting": {"pairs": MEET, **FAST},
    "wished clearance": {"map": ROOM, "sam": "clearance: 0.2,", "ann": "clearance: 0.25,"},
    "wide barriers": {"map": ROOM, "solver": "barrier_range: 0.5, mu: 0.3"},
    "smooth minimum": {"map": ROOM, "pairs": FRIENDS, "solver": SMOOTH},
    "blunt smooth minimum": {"map": ROOM, "solver": f"{SMOOTH}, alpha: 5"},
    "very blunt smooth minimum": {"solver": f"{SMOOTH}, alpha: 1, barrier_range: 0.3"},
    "unbounded smooth minimum": {"map": ROOM, "solver": f"{SMOOTH}, barrier_range: .inf"},
    "the paper's recipe": {
        "map": ROOM,
        "pairs": FRIENDS,
        "solver": f"{SMOOTH}, barrier_range: .inf, alpha: 10, alpha_rule: stepped, hessian_cutoff: 0.1",
    },
    "unbounded": {"map": ROOM, "solver": "barrier_range: .inf"},
    "exact Hessian": {"map": ROOM, "pairs": FRIENDS, "solver": "hessian: exact"},
}


def audited(text: str) -> tuple[Optimisation, Audit]:
    """The optimisation of a scene from YAML, every value of it computed anew."""
    scene = parse_scene(text)
    problem = prepare(scene)
    (initial,) = find_initial_curves(problem)
    seed = initial.seed.world_lines
    formulation = formulate(problem, seed)
    mu = formulation.scales.mu
    brute = BruteForce(
        yaml.safe_load(text),
        CostScales(formulation, mu, {}).as_dict(),
        {agent.id: agent.mass for agent in scene.agents},
        {agent.id: agent.radius for agent in scene.agents},
        scene.time_scale,
    )
    audit = Audit(formulation, seed, brute, mu)
    found = optimise(
        problem, seed, progress=lambda line: audit.next_mu(), stop=lambda: False, backend=audit
    )
    return found, audit


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_value_of_a_whole_solve_is_that_of_brute_force(variant: str) -> None:
    found, audit = audited(scene_text(VARIANTS[variant]))
    # At least once an iteration, and every one of these was compared.
    assert audit.evaluations > found.iterations > 10
    assert audit.evaluations > 30
    # Lists of contacts were replaced on the way.
    assert audit.renewals > 3
    assert np.isfinite([done.objective for done in found.outer_iterations]).all()


def test_touching_curves_and_refused_steps_are_among_those_values() -> None:
    audits = [audited(scene_text(VARIANTS[variant]))[1] for variant in ("open", "close friends")]
    assert sum(audit.touching for audit in audits) > 0
    assert sum(audit.touching + audit.refused for audit in audits) < sum(
        audit.evaluations for audit in audits
    )


@pytest.mark.parametrize("variant", ["smooth minimum", "blunt smooth minimum"])
def test_sharpness_is_kept_from_program_to_program(variant: str) -> None:
    found, audit = audited(scene_text(VARIANTS[variant]))
    rebuilds = sum(done.rebuilds for done in found.outer_iterations)
    assert len(audit.sharpness) == len(found.outer_iterations) + rebuilds >= 2
    for before, after in pairwise(audit.sharpness):
        assert set(before) == set(after) == {"collision", "wall"}
        for term, alphas in before.items():
            known = ~np.isnan(alphas)
            assert known.any()
            assert np.array_equal(after[term][known], alphas[known])
    for term, alphas in audit.sharpness[-1].items():
        assert np.array_equal(found.scales.sharpness[term], alphas, equal_nan=True)


def test_sharpness_is_chosen_for_pairs_that_come_near_later() -> None:
    _, audit = audited(
        scene_text({"map": ROOM, "pairs": FRIENDS, "solver": f"{SMOOTH}, alpha: 200"})
    )
    first, last = (np.isnan(audit.sharpness[k]["collision"]) for k in (0, -1))
    # Friends who start apart.
    assert last.sum() < first.sum()


def optimised(
    scene: Scene, after: Mapping[int, int], backend: Backend | None = None
) -> tuple[Optimisation, Failing]:
    """The optimisation of the scene's seed by a backend whose runs fail `after` so many iterations."""
    problem = prepare(scene)
    (initial,) = find_initial_curves(problem)
    failing = Failing(ipopt(scene) if backend is None else backend, after)
    found = optimise(
        problem, initial.seed.world_lines, progress=lambda line: None, stop=lambda: False,
        backend=failing,
    )  # fmt: skip
    written = problem.written
    assert certify(scene, written.free_space, written.outside(found.world_lines)).holds
    numbers = [done.objective for done in found.outer_iterations]
    assert np.isfinite([*numbers, *found.costs.values(), *found.seed_costs.values()]).all()
    return found, failing


def friends() -> Scene:
    """Whose optimisation is rebuilt in its first outer iteration."""
    return parse_scene(scene_text(VARIANTS["close friends"]))


def test_what_is_newly_felt_is_given_room_by_rebuilding() -> None:
    found, watched = optimised(friends(), {})
    rebuilds = [done.rebuilds for done in found.outer_iterations]
    assert rebuilds[0] > 0
    assert len(watched.runs) == len(rebuilds) + sum(rebuilds)
    for start, control, _ in watched.runs:
        fresh = StepControl(control.program, start)
        assert not fresh.is_stale(), "a program has room for all that is felt where it starts"
    assert any(control.is_stale() for _, control, _ in watched.runs), "but not for what comes later"
    assert found.status is Status.CONVERGED
    ends = [solution.knots for _, _, solution in watched.runs]
    for end, (start, _, _) in zip(ends, watched.runs[1:], strict=False):
        assert np.array_equal(start, end)


def test_a_rebuilt_run_that_fails_at_once_ends_its_outer_iteration() -> None:
    whole, _ = optimised(friends(), {})
    found, watched = optimised(friends(), {1: 0})
    first = found.outer_iterations[0]
    assert first.status is Status.FAILED
    assert (first.rebuilds, first.iterations) == (1, REBUILD_EVERY)
    # It had come some way before that: the next mu goes on from there.
    assert [done.status for done in found.outer_iterations[1:]] == [Status.CONVERGED]
    assert len(watched.runs) == 3 + found.outer_iterations[1].rebuilds
    assert sum(found.costs.values()) == pytest.approx(sum(whole.costs.values()), rel=1e-3)


def test_iterations_used_up_are_a_limit() -> None:
    scene = circle(3, 3.0, 12.0)
    scene = replace(scene, solver=replace(scene.solver, max_iterations=1, outer_iterations=3))
    found, _ = optimised(scene, {})
    assert found.status is Status.LIMIT
    assert [done.status for done in found.outer_iterations] == [Status.LIMIT] * 3
    assert [done.iterations for done in found.outer_iterations] == [1] * 3
    assert sum(found.costs.values()) < sum(found.seed_costs.values())


def test_without_any_step_the_first_outer_iteration_is_the_last_and_failed() -> None:
    found, watched = optimised(circle(3, 3.0, 12.0), {0: 0})
    assert found.status is Status.FAILED
    assert [done.status for done in found.outer_iterations] == [Status.FAILED]
    assert len(watched.runs) == 1
    assert found.costs == found.seed_costs
    assert np.array_equal(found.world_lines.knots, watched.runs[0][0])


def test_who_fails_after_some_steps_goes_on_at_the_next_mu() -> None:
    found, watched = optimised(circle(3, 3.0, 12.0), {0: 1})
    words = [done.status for done in found.outer_iterations]
    assert words == [Status.FAILED, *[Status.CONVERGED] * 4]
    assert found.status is Status.CONVERGED
    assert len(watched.runs) == 5


def test_who_fails_at_a_later_mu_without_any_step_keeps_what_was_found_before() -> None:
    found, watched = optimised(circle(3, 3.0, 12.0), {2: 0})
    words = [done.status for done in found.outer_iterations]
    assert words == [Status.CONVERGED, Status.CONVERGED, Status.FAILED]
    assert found.status is Status.CONVERGED
    assert np.array_equal(found.world_lines.knots, watched.runs[1][2].knots)
    assert found.scales.as_dict()["mu"] == found.outer_iterations[-1].mu


def test_all_runs_that_fail_are_reported_so() -> None:
    found, _ = optimised(circle(3, 3.0, 12.0), dict.fromkeys(range(5), 1))
    assert {done.status for done in found.outer_iterations} == {Status.FAILED}
    assert found.status is Status.FAILED
    assert sum(found.costs.values()) < sum(found.seed_costs.values())


def test_from_curves_that_touch_nothing_is_done_and_nothing_infinite_reported() -> None:
    scene = circle(2, 3.0, 12.0)
    problem = prepare(scene)
    straight = [
        np.array([[*one.start, 0.0], [0, 0, 6.0], [*one.goal, 12.0]]) for one in scene.agents
    ]
    seed = WorldLines.from_curves(problem.agent_ids, straight)
    found = optimise(problem, seed, progress=lambda line: None, stop=lambda: False)
    assert found.status is Status.FAILED
    assert found.outer_iterations == ()
    assert np.array_equal(found.world_lines.knots, seed.knots)
    assert "collision" not in found.costs
    assert found.costs == found.seed_costs
    assert found.costs["kinetic"] > 0


def blunt(name: str, **solver: object) -> Plan:
    """The plan of a shipped scene by the smooth minimum of alpha 5, the first seed that is found."""
    scene = load_scene(SCENES / "tight" / f"{name}.yaml")
    chosen = replace(
        scene.solver, clearance_model="smooth-minimum", alpha=5.0, effort="quick", **solver
    )
    plan = stplan.plan(replace(scene, solver=chosen))
    assert plan.exit_status == 0
    assert plan.certificate.holds
    assert plan.report.optimisation is not None
    found = plan.report.optimisation
    assert all(np.isfinite(done.objective) for done in found.outer_iterations)
    assert all(done.clearance > 0 for done in found.outer_iterations)
    assert plan.status is found.outer_iterations[-1].status
    before, after = plan.report.seed.metrics, plan.report.metrics
    assert after.kinetic_over_straight < 0.98 * before.kinetic_over_straight
    return plan


def test_a_blunt_smooth_minimum_plans_the_cabin() -> None:
    assert blunt("cabin").status is Status.CONVERGED


def test_a_blunt_smooth_minimum_goes_on_through_the_door() -> None:
    plan = blunt("door", max_iterations=12, outer_iterations=2)
    assert plan.status in (Status.LIMIT, Status.CONVERGED)


@pytest.mark.claims
def test_a_blunt_smooth_minimum_plans_the_door() -> None:
    assert blunt("door").status is Status.CONVERGED
