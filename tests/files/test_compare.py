"""A comparison says which agent, which knot and when."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stplan.files.compare import compare_trajectories
from stplan.files.json_file import json_bytes
from stplan.problem.world_lines import WorldLines
from tests.files.examples import random_lines, scene_of, straight_lines


def _moved(lines: WorldLines, row: int, column: int, amount: float) -> WorldLines:
    knots = lines.knots.copy()
    knots[row, column] += amount
    return lines.with_knots(knots)


@pytest.fixture
def lines():
    return straight_lines(scene_of(["sam", "ann"]), 5)


def test_a_file_equals_itself():
    lines = random_lines(["a", "b", "c"], np.random.default_rng(0))
    difference = compare_trajectories(lines, lines, atol=0.0)
    assert difference.equal
    assert difference.lines() == ["equal: 3 agents"]


def test_names_agent_knot_and_time(lines):
    other = _moved(_moved(lines, 7, 1, 1e-3), 1, 0, 1e-6)
    difference = compare_trajectories(lines, other)
    assert not difference.equal
    sam, ann = difference.agents
    assert ann.position is not None
    assert ann.position.amount == pytest.approx(1e-3)
    assert (ann.position.knot, ann.position.time) == (2, 2.5)
    assert sam.position is not None
    assert sam.position.knot == 1
    first, second = difference.lines()
    assert first.startswith("ann: position 0.001 m at knot 2 (t = 2.5 s)")
    assert second.startswith("sam: position 1e-06 m at knot 1 (t = 1.25 s)")


def test_times_count_too(lines):
    (sam, _) = compare_trajectories(lines, _moved(lines, 1, 2, 0.25)).agents
    assert not sam.equal
    assert sam.position is not None
    assert sam.position.amount == 0.0
    assert sam.time is not None
    assert (sam.time.amount, sam.time.knot) == (0.25, 1)
    # 0.8 m/s, and a quarter of a second late at t = 1.5 s.
    assert sam.simultaneous is not None
    assert sam.simultaneous.amount == pytest.approx(0.2)
    assert sam.simultaneous.time == 1.5


@pytest.mark.parametrize(
    ("atol", "rtol", "equal"),
    [(1e-3, 0.0, True), (0.9e-3, 0.0, False), (0.0, 1e-3, True), (0.0, 1e-4, False)],
)
def test_tolerances(lines, atol, rtol, equal):
    other = _moved(lines, 4, 0, 0.99e-3)
    assert compare_trajectories(lines, other, atol, rtol).equal is equal
    assert compare_trajectories(other, lines, atol, rtol).equal is equal


def test_other_numbers_of_knots_are_compared_in_time(lines):
    finer = straight_lines(scene_of(["sam", "ann"]), 9)
    difference = compare_trajectories(lines, finer)
    assert not difference.equal
    for agent in difference.agents:
        assert agent.num_knots == (5, 9)
        assert agent.position is None
        assert agent.simultaneous is not None
        assert agent.simultaneous.amount < 1e-12
    assert difference.lines()[0].startswith("sam: 5 knots against 9, at one instant up to")


def test_agents_missing_added_reordered(lines):
    sam, ann = lines.curves()
    swapped = WorldLines.from_curves(["ann", "sam"], [ann, sam])
    difference = compare_trajectories(lines, swapped)
    assert not difference.equal
    assert difference.reordered
    assert difference.lines() == ["the agents stand in another order"]
    other = WorldLines.from_curves(["sam", "eve"], [sam, ann])
    difference = compare_trajectories(lines, other)
    assert (difference.missing, difference.added, difference.reordered) == (
        ("ann",),
        ("eve",),
        False,
    )
    assert difference.lines() == ["ann: only in the first", "eve: only in the second"]


def test_no_instant_in_common_and_time_running_back(lines):
    late = lines.with_knots(lines.knots + np.array([0.0, 0.0, 100.0]))
    assert compare_trajectories(lines, late).agents[0].simultaneous is None
    assert "no instant in common" in compare_trajectories(lines, late).lines()[0]
    back = _moved(lines, 1, 2, 100.0)
    assert compare_trajectories(lines, back).agents[0].simultaneous is None


def test_simultaneous_difference_is_the_true_maximum():
    rng = np.random.default_rng(5)
    curves = []
    for count in (4, 6):
        curve = rng.normal(size=(count, 3))
        curve[:, 2] = np.sort(rng.uniform(0, 5, count))
        curves.append(curve)
    a, b = (WorldLines.from_curves(["x"], [curve]) for curve in curves)
    spot = compare_trajectories(a, b).agents[0].simultaneous
    assert spot is not None
    times = np.linspace(
        max(curves[0][0, 2], curves[1][0, 2]), min(curves[0][-1, 2], curves[1][-1, 2]), 20001
    )
    apart = [
        np.interp(times, curves[0][:, 2], curves[0][:, axis])
        - np.interp(times, curves[1][:, 2], curves[1][:, axis])
        for axis in range(2)
    ]
    sampled = np.hypot(*apart).max()
    assert sampled <= spot.amount <= sampled + 1e-2


def test_goes_into_json(lines):
    content = json.loads(
        json_bytes(compare_trajectories(lines, _moved(lines, 0, 0, 1.0)).as_dict())
    )
    assert content["equal"] is False
    assert content["agents"][0]["position"] == {"amount": 1.0, "knot": 0, "time": 0.0}
