"""Agents that never meet do not hold each other up, and those that come to meet are optimised together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.optimize.components import components
from stplan.optimize.parts import DividedProblem
from stplan.planner import Plan, find_initial_curves, plan, prepare
from stplan.scene import parse_scene
from stplan.scene.model import Scene

# Two pairs that each have to pass each other, far apart, and one walker of its own.
PAIRS = """
stplan: 1
horizon: 40
time_scale: 1
defaults: {{radius: 0.3, after_arrival: vanish, max_speed: 1.6, max_acceleration: 1.0}}
agents:
  - {{id: a, start: [0, 0], goal: [12, 0], preferred_time: 9,
     weights: {{arrival: {weight}, kinetic: {weight}}}}}
  - {{id: b, start: [12, 0.1], goal: [0, 0.1], preferred_time: 9, weights: {{arrival: 1}}}}
  - {{id: c, start: [0, 50], goal: [12, 50], preferred_time: 10, weights: {{arrival: 1}}}}
  - {{id: d, start: [12, 50.1], goal: [0, 50.1], preferred_time: 14, weights: {{arrival: 5}}}}
  - {{id: e, start: [0, 90], goal: [7, 90], preferred_time: 8, weights: {{arrival: 2}}}}
"""


def pairs(weight: float = 1.0, agents: slice = slice(None)) -> Scene:
    scene = parse_scene(PAIRS.format(weight=weight))
    chosen = scene.agents[agents]
    return replace(scene, agents=chosen, agent_paths=(), solver=replace(scene.solver, starts=1))


def arrivals(result: Plan) -> dict[str, float]:
    assert result.exit_status == 0
    assert result.certificate.holds
    lines = result.trajectories
    assert lines is not None
    return {
        name: float(curve[-1, 2])
        for name, curve in zip(lines.agent_ids, lines.curves(), strict=True)
    }


def test_components_are_those_who_have_to_do_with_each_other() -> None:
    problem = prepare(pairs())
    (initial,) = find_initial_curves(problem)
    lines = initial.seed.world_lines
    found = components(DividedProblem(problem, lines, lambda: False))
    assert sorted(one.tolist() for one in found) == [[0, 1], [2, 3], [4]]


def test_whoever_is_alone_arrives_as_if_nobody_else_were_there() -> None:
    together, alone = arrivals(plan(pairs())), arrivals(plan(pairs(agents=slice(4, 5))))
    assert together["e"] == pytest.approx(alone["e"], rel=1e-3)


@pytest.mark.parametrize("weight", [1e-3, 1e3])
def test_one_agent_s_weights_are_nothing_to_those_it_never_meets(weight: float) -> None:
    plain, scaled = arrivals(plan(pairs())), arrivals(plan(pairs(weight)))
    for name in ("c", "d", "e"):
        assert scaled[name] == pytest.approx(plain[name], rel=1e-3), name


def test_those_who_come_into_view_of_each_other_are_joined() -> None:
    # Friends pull one of them towards a walker that was far off.
    text = """
stplan: 1
horizon: 20
defaults: {radius: 0.3, after_arrival: vanish}
agents:
  - {id: a, start: [0, 0], goal: [12, 0]}
  - {id: b, start: [0, 6], goal: [12, 6]}
  - {id: w, start: [12, 3], goal: [0, 3]}
pairs: [{between: [a, b], grouping: 30}]
solver: {starts: 1}
"""
    result = plan(parse_scene(text))
    assert result.certificate.holds
    together = plan(parse_scene(text, overrides=("solver.blocks=all",)))
    costs = [sum(one.report.optimisation.costs.values()) for one in (result, together)]
    assert costs[0] == pytest.approx(costs[1], rel=2e-2)


def test_the_whole_is_one_program_where_all_are_in_view() -> None:
    near = replace(pairs(), agents=pairs().agents[:2])
    apart = replace(near, solver=replace(near.solver, blocks="all"))
    first, second = plan(near).trajectories, plan(apart).trajectories
    assert first is not None
    assert second is not None
    assert np.array_equal(first.knots, second.knots)
