"""Where nothing was found, what may be changed is named."""

from __future__ import annotations

import pytest

from stplan.errors import SeedingError
from stplan.planner import prepare
from stplan.problem.planning_problem import PlanningProblem
from stplan.reasons import Reason
from stplan.scene import parse_scene
from stplan.seeding.portfolio import find_seed
from stplan.seeding.remedies import remedies, usual_pace
from stplan.wording import sentence

HEAD = "stplan: 1\nhorizon: 10\n"
CARS = """agents:
  - {id: a, start: [0, 0], goal: [150, 0]}
  - {id: b, start: [0, 9], goal: [150, 9], preferred_time: 5, weights: {arrival: 1, kinetic: 0}}
  - {id: c, path: [[0, 20, 0], [1, 20, 9]]}
"""


def advice(top: str, *reasons: Reason) -> list[str]:
    """The advice about a scene in words."""
    problem = PlanningProblem.from_scene(parse_scene(HEAD + top + CARS), None)
    return [sentence(one) for one in remedies(problem, reasons)]


def test_a_time_scale_far_below_the_speed() -> None:
    assert usual_pace(PlanningProblem.from_scene(parse_scene(HEAD + CARS), None)) == pytest.approx(
        22.5
    )
    (said,) = advice("time_scale: 1.0\n")
    assert said.startswith("agents go at about 22 m/s, far more than time_scale")
    assert advice("time_scale: 15.0\n") == []


def test_what_was_asked_for() -> None:
    method, margin = advice("time_scale: 15.0\nseeding: {method: relaxation, margin: 1.3}\n")
    assert "seeding.method allows one way to look for curves only; auto tries all" in method
    assert "seeding.margin asks for 1.3 times the distances" in margin


def test_more_time_where_agents_block_each_other() -> None:
    (said,) = advice("time_scale: 15.0\n", Reason("touching", ("a", "b")))
    assert "a later horizon, or max_time" in said
    assert advice("time_scale: 15.0\n", Reason("roadmap", ("a",))) == []


def test_a_search_that_fails_gives_it() -> None:
    # Nobody can get past each other in a lane, and only relaxation may try.
    text = """map: {rectangle: [0, 0, 12, 1]}
time_scale: 1.0
seeding: {method: relaxation, time_limit: 3}
agents:
  - {id: a, start: [1, 0.5], goal: [11, 0.5]}
  - {id: b, start: [11, 0.5], goal: [1, 0.5]}
"""
    with pytest.raises(SeedingError) as caught:
        find_seed(prepare(parse_scene(HEAD + text)), progress=lambda line: None)
    kinds = [reason.kind for reason in caught.value.reasons]
    assert "method" in kinds
    assert "seeding.method" in str(caught.value)
