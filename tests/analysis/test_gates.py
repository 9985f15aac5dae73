"""Gates: the lines that agents have to pass, and the ways on both sides of them."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.gates import find_gates
from stplan.analysis.shortest_trips import shortest_legs
from stplan.problem.planning_problem import prepare
from stplan.scene import parse_scene

ROOMS = """\
stplan: 1
horizon: 40.0
map:
  rectangle: [-5, 0, 5, 5]
  obstacles: [{{rectangle: [-0.2, 0, 0.2, 2]}}, {{rectangle: [-0.2, {top}, 0.2, {end}]}}]
defaults: {{radius: 0.3}}
agents:
  - {{id: a, start: [-4, 1], goal: [4, 4]}}
  - {{id: b, start: [4, 1], goal: [-4, 4]}}
  - {{id: c, start: [-4, 3], goal: [-2, 1]}}
  - {{id: d, start: [4, 3], goal: [-4, 2], radius: {radius}}}
"""


def gates_of(top=2.8, end=5.0, radius=0.3):
    problem = prepare(parse_scene(ROOMS.format(top=top, end=end, radius=radius)))
    return find_gates(problem, range(problem.num_agents), shortest_legs(problem))


def test_a_thick_door_has_a_gate_on_each_side_for_who_changes_rooms():
    gates = gates_of()
    assert sorted(gate.ends[0, 0] for gate in gates) == pytest.approx([-0.2, 0.2])
    for gate in gates:
        assert gate.width == pytest.approx(0.8)
        assert gate.agents.tolist() == [0, 1, 3]
        straight = np.hypot(4.0 - abs(gate.ends[0, 0]), 1.4)
        assert gate.before[0] <= np.hypot(4.0 + gate.ends[0, 0], 1.4)
        assert gate.before[0] >= straight - 0.2
        assert np.all(gate.before + gate.after <= gate.whole + 1e-9)
        assert np.all(gate.before + gate.after >= gate.whole - 0.3)


def test_a_second_way_leaves_no_gate_and_one_too_narrow_does_not_count():
    assert gates_of(end=4.0) == []
    # What is left above the upper wall is too narrow for anybody.
    gates = gates_of(end=4.5)
    assert gates
    assert all(gate.width == pytest.approx(0.8) for gate in gates)


def test_who_does_not_fit_or_two_who_fit_side_by_side_have_no_gate():
    assert [gate.agents.tolist() for gate in gates_of(radius=0.39)] == [[0, 1, 3]] * 2
    assert [gate.agents.tolist() for gate in gates_of(radius=0.41)] == [[0, 1]] * 2
    assert gates_of(top=3.8) == []


def test_the_open_has_no_gates():
    scene = parse_scene("stplan: 1\nhorizon: 9\nagents: [{id: a, start: [0, 0], goal: [3, 0]}]\n")
    problem = prepare(scene)
    assert find_gates(problem, [0], shortest_legs(problem)) == []
