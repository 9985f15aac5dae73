"""Margins give way to what cannot move and to what curves hold."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.problem.clearance import rod_clearances
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import held_requirement, least_requirement, requirement
from stplan.problem.verification import verify
from tests.problem.samples import random_problem, room
from tests.seeding.families import agent, scene


def test_the_margin_gives_way_to_fixed_ends() -> None:
    agents = [
        agent("a", (0, 0), (9, 0)),
        agent("b", (0, 1.02), (9, 3)),
        agent("c", (0, 5), (9, 1.01)),
        agent("d", (30, 5), (39, 5)),
    ]
    wanted = requirement(PlanningProblem.from_scene(scene(agents), None), 1.05).rods
    assert wanted[0, 1] == wanted[1, 0] == pytest.approx(1.01)
    assert wanted[0, 2] == pytest.approx(1.005)
    assert wanted[0, 3] == wanted[1, 2] == pytest.approx(1.05)
    standing = requirement(PlanningProblem.from_scene(scene(agents), None), 1.0).rods
    assert standing == pytest.approx(np.ones((4, 4)))


def test_the_margin_gives_way_near_walls() -> None:
    agents = [agent("a", (0.51, 5), (9, 5)), agent("b", (5, 5), (2, 2))]
    wanted = requirement(PlanningProblem.from_scene(scene(agents), room()), 1.05).walls
    assert wanted == pytest.approx([0.505, 0.525])


def test_a_held_requirement_never_asks_for_more_than_the_curves_have() -> None:
    agents = [agent("a", (0, 0), (9, 0)), agent("b", (0, 5), (9, 5))]
    curves = [
        np.array([[0, 0, 0], [5, 0, 9], [9, 0, 20.0]]),
        np.array([[0, 5, 0], [5, 1.02, 9], [9, 5, 20.0]]),
    ]
    problem = PlanningProblem.from_scene(scene(agents), None)
    gap = rod_clearances(problem, curves).distance[0]
    held = held_requirement(problem, curves, requirement(problem, 1.05))
    assert held.rods[0, 1] == pytest.approx(1 + 0.9 * (gap - 1))
    assert verify(problem, curves, held) == []
    assert verify(problem, curves, requirement(problem, 1.05)) != []


def test_no_margin_asks_for_less_than_the_least() -> None:
    problem, _ = random_problem(np.random.default_rng(3), 8)
    least = least_requirement(problem)
    for margin in (1.0, 1.02, 1.2):
        asked = requirement(problem, margin)
        assert (asked.rods >= least.rods).all()
        assert (asked.walls >= least.walls).all()
    bare = requirement(problem, 1.0)
    assert np.array_equal(bare.rods, least.rods)
    assert np.array_equal(bare.walls, least.walls)
