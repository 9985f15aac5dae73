"""Lanes between parallel walls, and who goes through them in opposite directions."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.lanes import find_lanes, opposed_in
from stplan.analysis.shortest_trips import shortest_legs
from stplan.planner import prepare
from stplan.scene import parse_scene

ROOMS = """\
stplan: 1
horizon: 30
map: {polygon: [[-2, -2], [2, -2], [2, -0.5], [8, -0.5], [8, -2], [12, -2],
                [12, 2], [8, 2], [8, 0.5], [2, 0.5], [2, 2], [-2, 2]]MORE}
defaults: {radius: 0.4}
agents:
  - {id: east, start: EAST, goal: [10, 1]}
  - {id: west, start: [10, -1], goal: WEST}
"""


def pairs(east="[0, 1]", west="[0, -1]", more="", radius="0.4", extra=""):
    text = ROOMS.replace("EAST", east).replace("WEST", west).replace("MORE", more)
    problem = prepare(parse_scene(text.replace("0.4}", f"{radius}}}") + extra))
    legs = shortest_legs(problem)
    lanes = find_lanes(problem, [0, 1])
    unit = problem.frame.length
    found = [pair for lane in lanes for pair in opposed_in(problem, lane, [0, 1], legs)]
    return [lane.length * unit for lane in lanes], found, problem


def test_a_lane_is_the_rectangle_between_two_walls_and_its_ends_are_measured():
    lengths, (pair,), problem = pairs()
    unit = problem.frame.length
    assert lengths == pytest.approx([6.0])
    assert [gate.width * unit for gate in pair.gates] == pytest.approx([1.0, 1.0])
    assert sorted(pair.agents.tolist()) == [0, 1]
    assert problem.frame.points(pair.middle[None])[0] == pytest.approx([5.0, 0.0], abs=1e-6)
    assert pair.room == (True, True)
    for gate in pair.gates:
        # Both have some way to either end, and the middles of ends are no further than centres are.
        assert (gate.before + gate.after <= gate.whole + 1e-6).all()
        assert (gate.before + gate.after > 0.9 * gate.whole).all()
    assert (pair.gates[1].before - pair.gates[0].before) * unit == pytest.approx(
        [6.0, -6.0], abs=0.1
    )


def test_who_starts_or_ends_in_a_lane_goes_through_a_part_of_it():
    _, (pair,), problem = pairs(east="[4, 0]", west="[5.5, 0]")
    places = problem.frame.points(np.array([gate.ends.mean(axis=0) for gate in pair.gates]))
    assert sorted(places[:, 0]) == pytest.approx([5.5, 8.0], abs=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        {"radius": "0.24"},  # Two fit side by side.
        {"more": ", obstacles: [{rectangle: [4, -0.1, 4.2, 0.1]}]", "radius": "0.15"},
        {"west": "[11, -1]"},  # It stays in its room.
        {"extra": "pairs: [{between: [east, west], collide: false}]\n"},
        {"east": "[9, 1]"},  # Both are on one side.
    ],
)
def test_nobody_is_opposed_where_nothing_forces_it(change):
    assert pairs(**change)[1] == []


def test_a_lane_with_a_way_round_it_is_none():
    text = """\
stplan: 1
horizon: 30
map: {rectangle: [0, 0, 14, 6], obstacles: [{rectangle: [4, 1, 10, 5]}]}
defaults: {radius: 0.4}
agents:
  - {id: a, start: [1, 3], goal: [13, 3]}
  - {id: b, start: [13, 2], goal: [1, 2]}
"""
    problem = prepare(parse_scene(text))
    lanes = find_lanes(problem, [0, 1])
    legs = shortest_legs(problem)
    assert len(lanes) == 2
    assert [opposed_in(problem, lane, [0, 1], legs) for lane in lanes] == [[], []]


def test_a_dead_end_has_no_room_for_a_second_one():
    text = """\
stplan: 1
horizon: 30
map: {polygon: [[0, -2], [4, -2], [4, -0.5], [9, -0.5], [9, 0.5], [4, 0.5], [4, 2], [0, 2]]}
defaults: {radius: 0.4}
agents:
  - {id: in, start: [1, 0], goal: [8.5, 0]}
  - {id: out, start: [8.4, 0], goal: [1, 1.5]}
"""
    problem = prepare(parse_scene(text))
    (lane,) = find_lanes(problem, [0, 1])
    (pair,) = opposed_in(problem, lane, [0, 1], shortest_legs(problem))
    assert sorted(pair.room) == [False, True]
