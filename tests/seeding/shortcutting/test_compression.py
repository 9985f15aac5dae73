"""Compression: as fast as may be, never nearer than is allowed, and only where times are free."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.planner import prepare
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene import parse_scene
from stplan.seeding.shortcutting.compression import SPARE, arriving_as, compressed

SCENE = """\
stplan: 1
minimise: makespan
horizon: 40
defaults: {{max_speed: 2}}
agents:
  - {{id: sam, start: [0, 0], goal: [6, 0]}}
  - {{id: ann, start: [0, 2], goal: [3, 2]{ann}}}
"""


def problem_of(ann: str = "") -> PlanningProblem:
    return prepare(parse_scene(SCENE.format(ann=ann)))


def straight(problem: PlanningProblem, duration: float) -> list[np.ndarray]:
    """Curves that take `duration` seconds."""
    local = duration / problem.frame.time
    return [
        np.vstack([[*start, begin], [*goal, begin + local]])
        for start, goal, begin in zip(
            problem.starts, problem.goals, problem.start_times, strict=True
        )
    ]


@pytest.mark.parametrize("duration", [30.0, 1.0])
def test_the_fastest_is_nearly_as_fast_as_it_may_be(duration):
    problem = problem_of()
    found = compressed(problem, straight(problem, duration))
    assert not verify(problem, found)
    for curve in found:
        assert problem.frame.times(curve[-1:, 2])[0] == pytest.approx(3.0 / SPARE)


def test_given_times_are_left_alone():
    given = (", start_time: 1", ", waypoints: [{at: [1, 2], dwell: 1}]", ", max_acceleration: 1")
    for ann in given:
        problem = problem_of(ann)
        curves = straight(problem, 30.0)
        for curve, same in zip(curves, compressed(problem, curves), strict=True):
            assert np.array_equal(curve, same)


def test_arrivals_become_what_agents_prefer():
    problem = problem_of()
    curves = straight(problem, 30.0)
    wished = arriving_as(problem, curves).preferred_times
    assert problem.frame.times(wished) == pytest.approx([30.0, 30.0])
