"""Curves slowed down to their limits: on the same ways, no more than it takes, and clear."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.formulation import Penalties, TermSetup
from stplan.costs.limit import limits_among
from stplan.costs.registry import build_terms
from stplan.nlp.term import Capability
from stplan.optimize.assembly import formulate
from stplan.optimize.slowing import slowed
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

SCENE = """
stplan: 1
horizon: 60
agents:
  - {id: sam, start: [0, 0], goal: [9, 0], max_speed: 1.5, max_acceleration: 1}
  - {id: ann, start: [0, 5], goal: [9, 5]}
  - {id: cart, path: [[0, 9, 0], [9, 9, 2]]}
"""


def problem_with(text: str = SCENE) -> PlanningProblem:
    return PlanningProblem.from_scene(parse_scene(text), None)


def even(problem: PlanningProblem, duration: float) -> WorldLines:
    """Everybody at an even pace, straight on."""
    share = np.linspace(0.0, 1.0, 31)[:, None]
    curves = []
    for start, goal, path in zip(problem.starts, problem.goals, problem.paths, strict=True):
        first, last = np.append(start, 0.0), np.append(goal, duration)
        curves.append(first + share * (last - first) if path is None else path)
    return WorldLines.from_curves(problem.agent_ids, curves)


def slow(problem: PlanningProblem, lines: WorldLines, *, alike: bool = False) -> FloatArray | None:
    formulation = formulate(problem, lines)
    setup = TermSetup(formulation, lines.knots, 0.0, Penalties(1.0, 1.0, 0.0))
    limits = limits_among(build_terms(setup, Capability.LIMIT))
    found = slowed(
        problem, formulation.layout, lines.knots, limits, lambda knots: True, alike=alike
    )
    assert found is None or all(term.is_kept(found) for term in limits)
    return found


def test_an_even_pace_becomes_one_from_rest_to_rest() -> None:
    problem = problem_with()
    lines = even(problem, 5.0)
    knots = slow(problem, lines)
    assert knots is not None
    assert np.array_equal(knots[:, :2], lines.knots[:, :2])
    sam, *others = lines.with_knots(knots).curves()
    # 1.5 m/s, after 1.5 s from rest and for as long before it: not much more than that takes.
    assert 7.5 < sam[-1, 2] < 1.15 * 7.5
    pace = np.diff(sam[:, 2])
    assert pace[0] > 2.0 * pace[15]
    assert pace[-1] > 2.0 * pace[15]
    assert all(np.array_equal(a, b) for a, b in zip(others, list(lines.curves())[1:], strict=True))


def test_whoever_is_slow_enough_keeps_its_times() -> None:
    problem = problem_with()
    lines = even(problem, 40.0)
    assert slow(problem, even(problem, 40.0)) == pytest.approx(lines.knots, abs=0.0)


def test_all_may_slow_down_alike_but_for_who_follows_a_path() -> None:
    problem = problem_with()
    lines = even(problem, 5.0)
    knots = slow(problem, lines, alike=True)
    assert knots is not None
    sam, ann, cart = lines.with_knots(knots).curves()
    assert ann[:, 2] == pytest.approx(sam[:, 2])
    assert np.ptp(np.diff(sam[:, 2])) < 1e-9
    assert np.array_equal(cart, problem.paths[2])


def test_nobody_is_later_than_it_may_be() -> None:
    problem = problem_with(SCENE.replace("horizon: 60", "horizon: 7"))
    assert slow(problem, even(problem, 5.0)) is None
