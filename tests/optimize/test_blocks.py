"""Optimisation in blocks: everybody once a sweep, every iterate clear, as cheap as all together."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stplan.arrays import FloatArray, IntArray
from stplan.bench import families_open as wide
from stplan.bench.families_crowds import grid_room
from stplan.nlp.step_control import Stopwatch
from stplan.optimize import blocks, parts
from stplan.optimize.blocks import at_once, block_size, split
from stplan.optimize.continuation import Optimisation
from stplan.optimize.parts import DividedProblem, PartResult
from stplan.optimize.surveyor import Surveyor
from stplan.optimize.whole import optimise_whole
from stplan.optimize.workers import on_this_machine
from stplan.planner import find_initial_curves, plan, prepare
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.status import Status


def in_blocks(scene: Scene, size: int | str | None) -> Scene:
    return replace(scene, solver=replace(scene.solver, blocks=size, effort="quick", starts=1))


def flows(size: int | str | None = 8) -> Scene:
    return in_blocks(wide.crossing_flows(24, 1.0, 3), size)


@pytest.fixture(scope="module")
def seeded() -> tuple[PlanningProblem, WorldLines]:
    problem = prepare(flows())
    (initial,) = find_initial_curves(problem)
    return problem, initial.seed.world_lines


def optimised(problem: PlanningProblem, seed: WorldLines) -> Optimisation:
    return optimise_whole(problem, seed, progress=lambda line: None, stop=lambda: False)


@pytest.mark.parametrize("sweep", [0, 1, 2])
def test_a_sweep_has_everybody_who_plans_once(sweep: int) -> None:
    problem = prepare(flows())
    found = split(problem, sweep, 8)
    assert sorted(np.concatenate(found).tolist()) == list(range(24))
    assert max(map(len, found)) <= 8
    others = split(problem, (sweep + 1) % 3, 8)
    assert {tuple(block) for block in found} != {tuple(block) for block in others}


def test_who_meets_or_is_a_friend_stays_together() -> None:
    agents = "\n".join(
        f"  - {{id: a{k}, start: [{3 * k}, 0], goal: [{3 * k}, 9]}}" for k in range(9)
    )
    path = "  - {id: bus, path: [[-9, 0, 0], [-9, 9, 9]]}"
    pairs = "[{between: [a0, a8], meet: {within: 20}}, {between: [a1, a7], grouping: 1}]"
    problem = prepare(
        parse_scene(f"stplan: 1\nhorizon: 20\npairs: {pairs}\nagents:\n{agents}\n{path}\n")
    )
    found = [set(block.tolist()) for block in split(problem, 0, 3)]
    assert set().union(*found) == set(range(9))
    for together in ({0, 8}, {1, 7}):
        assert any(together <= block for block in found)


def test_blocks_are_for_many_agents_unless_they_are_asked_for() -> None:
    assert block_size(prepare(flows(None))) is None
    assert block_size(prepare(flows("all"))) is None
    assert block_size(prepare(flows(24))) is None
    assert block_size(prepare(flows(8))) == 8
    assert block_size(prepare(in_blocks(wide.open_field(200, 0.01), None))) is None
    assert block_size(prepare(in_blocks(wide.open_field(201, 0.01), None))) == blocks.BLOCK
    assert block_size(prepare(grid_room(201, 0))) is None


def test_as_cheap_as_all_together_and_as_clear(seeded: tuple[PlanningProblem, WorldLines]) -> None:
    problem, seed = seeded
    whole = replace(problem, scene=flows("all"))
    together, apart = optimised(whole, seed), optimised(problem, seed)
    assert apart.status is Status.CONVERGED
    assert not verify(problem, list(apart.world_lines.curves()))
    costs = [
        total_kinetic_cost(problem.masses, list(lines.curves()))
        for lines in (seed, together.world_lines, apart.world_lines)
    ]
    assert costs[1] < costs[0]
    assert costs[2] < 1.006 * costs[1]
    assert costs[0] > 1.01 * costs[1]
    assert np.isfinite(list(apart.costs.values())).all()
    assert set(apart.costs) == set(together.costs)


def test_what_came_near_out_of_view_is_seen_the_next_time(
    seeded: tuple[PlanningProblem, WorldLines], monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, seed = seeded
    views = []
    around = Surveyor.around

    def noted(self: Surveyor, knots: FloatArray, agents: IntArray, view: float, *more: Any) -> Any:
        views.append(view)
        return around(self, knots, agents, view, *more)

    monkeypatch.setattr(Surveyor, "around", noted)
    monkeypatch.setattr(parts, "VIEW", 1e-3)
    found = optimised(problem, seed)
    assert max(views) > 1e-3
    assert not verify(problem, list(found.world_lines.curves()))


def test_a_stop_between_blocks_leaves_a_clear_plan(
    seeded: tuple[PlanningProblem, WorldLines],
) -> None:
    problem, seed = seeded
    asked = iter(range(10**9))
    found = optimise_whole(problem, seed, progress=lambda line: None, stop=lambda: next(asked) > 60)
    assert found.status is Status.INTERRUPTED
    assert not verify(problem, list(found.world_lines.curves()))


def test_blocks_at_once_are_loosely_coupled() -> None:
    split_in_four = [np.arange(4) + 4 * k for k in range(4)]
    inside = [(a, a + 1) for k in range(4) for a in range(4 * k, 4 * k + 3)]
    near = np.array([*inside, *[(a, a + 4) for a in range(4)], *[(a, a + 4) for a in range(8, 12)]])
    found = at_once(split_in_four, near, 16)
    numbers = [sorted(int(block[0]) // 4 for block in group) for group in found]
    assert sorted(number for group in numbers for number in group) == [0, 1, 2, 3]
    assert not any({0, 1} <= set(group) or {2, 3} <= set(group) for group in numbers)
    assert max(map(len, numbers)) == 2


def test_who_would_touch_somebody_stays_with_all_who_then_would(
    seeded: tuple[PlanningProblem, WorldLines],
) -> None:
    problem, seed = seeded
    parts = DividedProblem(problem, seed, lambda: False)
    block = np.arange(12)
    before = parts.knots.copy()
    # One goes the way of another one, who is in another block.
    own, other = parts.curve(3).copy(), parts.curve(20)
    curves = [parts.curve(agent).copy() for agent in block.tolist()]
    curves[3] = np.linspace(other[0], other[-1], len(own))
    result = PartResult(block, tuple(curves), 5, 7, Stopwatch())
    assert parts.take_clear(result, np.arange(24)).tolist() == [3]
    assert np.array_equal(parts.knots, before)
    together = np.arange(24)
    together[5] = 3
    assert parts.take_clear(result, together).tolist() == [3, 5]


def test_the_same_bytes_whoever_optimises() -> None:
    problem = prepare(flows(4))
    (initial,) = find_initial_curves(problem)
    found = [
        optimise_whole(
            problem, initial.seed.world_lines,
            progress=lambda line: None, stop=lambda: False, workers=on_this_machine(number),
        )
        for number in (1, 3)
    ]  # fmt: skip
    assert np.array_equal(found[0].world_lines.knots, found[1].world_lines.knots)
    assert found[0].outer_iterations == found[1].outer_iterations


def test_a_scene_in_blocks_is_certified_and_repeats() -> None:
    first, second = plan(flows(6)), plan(flows(6), num_workers=2)
    assert first.exit_status == 0
    assert first.certificate.holds
    assert first.trajectories is not None
    assert second.trajectories is not None
    assert np.array_equal(first.trajectories.knots, second.trajectories.knots)
