"""Large-neighbourhood search on finished plans: never dearer, certified, repeatable, stopped at any time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis.own_costs import own_costs
from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.certify.certificate import certify
from stplan.improvement.budget import ImprovementBudget
from stplan.improvement.proposals import MOVES, Proposals
from stplan.improvement.search import Improvement, improve
from stplan.planner import Plan, plan
from stplan.problem.planning_problem import prepare
from stplan.problem.verification import verify
from stplan.scene.model import Scene


def quick(scene: Scene) -> Scene:
    return replace(scene, solver=replace(scene.solver, knots=20, starts=1))


def quick_plan(scene: Scene) -> Plan:
    return plan(quick(scene))


@pytest.fixture(scope="module")
def crossing() -> Plan:
    return quick_plan(tight.plus_crossing(np.random.default_rng(1), turn=3))


@pytest.fixture(scope="module")
def circle() -> Plan:
    return quick_plan(wide.circle(6, 3.0, 20.0, radius=0.4))


def improved(found: Plan, moves: int, **options) -> Improvement:
    options = {"progress": lambda line: None, "stop": lambda: False, "rng_seed": 1} | options
    budget = options.pop("budget", ImprovementBudget(moves=moves))
    return improve(prepare(found.scene), found.trajectories, budget, **options)


@pytest.mark.parametrize("name", ["crossing", "circle"])
def test_a_plan_never_gets_dearer_and_holds_its_certificate(name, request):
    found = request.getfixturevalue(name)
    result = improved(found, 12)
    before, after = (
        float(own_costs(found.scene, lines).sum())
        for lines in (found.trajectories, result.world_lines)
    )
    problem = prepare(found.scene)
    assert after <= before
    assert certify(found.scene, problem.free_space, result.world_lines).holds
    assert result.certificate.holds
    record = result.record
    assert (record.cost_before, record.cost_after) == pytest.approx((before, after))
    assert record.moves == 12 == sum(kind["tried"] for kind in record.kinds.values())
    assert record.accepted == len(record.history)
    costs = [before, *(step["cost"] for step in record.history)]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] == pytest.approx(after)
    assert not result.interrupted


def test_a_dear_class_is_left():
    """From a plan in which agents wait for each other, some move leads to a cheaper class."""
    scene = quick(wide.circle(8, 3.0, 20.0, radius=0.4))
    dear = plan(replace(scene, seeding=replace(scene.seeding, method="search")))
    cost = float(own_costs(scene, dear.trajectories).sum())
    result = improved(dear, 25)
    assert result.record.accepted > 0
    assert result.record.cost_after < 0.995 * cost


def test_same_moves_same_bytes(circle):
    first, second = (improved(circle, 8, rng_seed=3) for _ in range(2))
    assert first.world_lines.knots.tobytes() == second.world_lines.knots.tobytes()
    assert first.record == second.record


def test_stopped_it_leaves_the_best_so_far(circle):
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 40

    result = improved(circle, 1000, stop=stop)
    assert result.interrupted
    assert result.record.moves < 1000
    assert result.certificate.holds
    assert result.record.cost_after <= result.record.cost_before


def test_without_time_nothing_is_tried(circle):
    result = improved(circle, 0, budget=ImprovementBudget(seconds=1e-9))
    assert result.world_lines is circle.trajectories
    assert result.record.moves == 0
    assert result.optimisation is None


def test_prescribed_motion_is_left_alone():
    scene = quick(wide.circle(2, 3.0, 20.0, radius=0.4))
    agents = tuple(
        replace(
            agent,
            path=(
                (*agent.start, 0.0),
                (agent.start[0], 10.0 * number - 5.0, 10.0),
                (*agent.goal, 20.0),
            ),
        )
        for number, agent in enumerate(scene.agents)
    )
    found = plan(replace(scene, agents=agents))
    result = improved(found, 5)
    assert result.world_lines is found.trajectories
    assert result.record.moves == 0


def test_limits_of_motion_are_kept():
    """Curves that moves lead to are brought within the limits before they are optimised."""
    scene = quick(wide.circle(4, 3.0, 8.0, radius=0.4))
    fastest = 1.3 * 6.0 / 8.0
    found = plan(replace(scene, agents=tuple(replace(a, max_speed=fastest) for a in scene.agents)))
    result = improved(found, 8)
    assert result.certificate.holds
    assert result.record.cost_after <= result.record.cost_before
    for curve in result.world_lines.curves():
        step = np.diff(curve, axis=0)
        assert (np.hypot(step[:, 0], step[:, 1]) <= fastest * step[:, 2] * (1.0 + 1e-9)).all()


def test_who_meets_nobody_is_left_alone():
    scene = quick(wide.circle(2, 3.0, 20.0, radius=0.4))
    alone = plan(replace(scene, agents=scene.agents[:1]))
    result = improved(alone, 5)
    assert result.world_lines is alone.trajectories
    assert result.record.moves == 0


@pytest.mark.parametrize("move", MOVES, ids=str)
def test_every_proposal_is_clear(move, circle):
    problem = prepare(circle.scene)
    proposals = Proposals(problem, np.random.default_rng(2))
    curves = list(circle.trajectories.curves())
    found = 0
    for _ in range(6):
        proposals.start_from(curves, np.ones(problem.num_agents))
        proposed = proposals.propose(move, lambda: False)
        if proposed is not None:
            found += 1
            assert not verify(problem, proposed)
            assert any(
                new.shape != old.shape or np.abs(new - old).max() > 1e-6
                for new, old in zip(proposed, curves, strict=True)
            )
    assert found > 0


def test_an_effort_ends_it_too(crossing):
    little, more = (
        improved(crossing, 0, budget=ImprovementBudget(effort=effort)).record
        for effort in (1.0, 30.0)
    )
    assert little.moves == 1 < more.moves
