"""Emptying a room: nearest first, everybody else standing until its turn."""

from __future__ import annotations

import pytest

from stplan.bench.families_crowds import exchange
from stplan.planner import prepare
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene import parse_scene
from stplan.seeding.search.emptying import Emptying
from stplan.seeding.search.levels import Levels
from stplan.seeding.seeder import Budget

ROOM = """stplan: 1
map:
  rectangle: [0, 0, 7, 3]
  obstacles: [{rectangle: [3, 0, 3.2, 1]}, {rectangle: [3, 2, 3.2, 3]}]
horizon: 90
defaults: {radius: 0.2, after_arrival: AFTER}
agents:
"""


def room(after: str, goals_apart: float) -> PlanningProblem:
    """A packed room of 16 behind a door of one metre."""
    lines = [
        f"  - {{id: p{k}, start: [{0.5 + 0.5 * (k % 4)}, {0.75 + 0.5 * (k // 4)}], "
        f"goal: [6.5, {1.5 + goals_apart * (k - 7.5):.3f}]}}"
        for k in range(16)
    ]
    return prepare(parse_scene(ROOM.replace("AFTER", after) + "\n".join(lines)))


@pytest.mark.parametrize("goals_apart", [0.0, 0.05])
def test_a_packed_room_is_emptied_in_one_round(goals_apart: float) -> None:
    problem = room("vanish", goals_apart)
    found = Emptying(Levels(problem)).attempt(Budget())
    assert found.clear
    assert not verify(problem, found.curves)
    assert found.tries < 2 * problem.num_agents


def test_those_nearest_the_door_leave_first() -> None:
    found = Emptying(Levels(room("vanish", 0.0))).attempt(Budget())
    arrival = [curve[-1, 2] for curve in found.curves]
    front, back = arrival[3::4], arrival[0::4]
    assert max(front) < max(back)


def test_an_exchange_is_given_up_soon() -> None:
    text = (
        "stplan: 1\nhorizon: 30\nmap: {rectangle: [0, 0, 6, 0.6]}\ndefaults: {radius: 0.2}\n"
        "agents: [{id: a, start: [1, 0.3], goal: [5, 0.3]}, {id: b, start: [5, 0.3], goal: [1, 0.3]}]"
    )
    found = Emptying(Levels(prepare(parse_scene(text)))).attempt(Budget())
    assert not found.clear
    assert found.tries <= 2 * 3 * 3


def test_those_who_leave_go_before_those_who_stay() -> None:
    problem = prepare(exchange(24, 0))
    found = Emptying(Levels(problem)).attempt(Budget())
    assert found.clear
    assert not verify(problem, found.curves)
    # One way was sought for everybody: turns were in the right order.
    assert found.tries == 24
