"""Gaps of arrivals: counted from the starts, of the sum or of the latest."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.arrival_gap import arrival_gap
from stplan.planner import prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

SCENE = """\
stplan: 1
minimise: {minimise}
horizon: 40
defaults: {{max_speed: 2}}
agents:
  - {{id: sam, start: [0, 0], goal: [6, 0], start_time: 1}}
  - {{id: ann, start: [0, 2], goal: [4, 2], start_time: 5}}
"""


def gap_of(minimise: str):
    problem = prepare(parse_scene(SCENE.format(minimise=minimise)))
    curves = [np.array([[0, 0, 1], [6, 0, 7.0]]), np.array([[0, 2, 5], [4, 2, 9.0]])]
    return arrival_gap(problem, WorldLines.from_curves(("sam", "ann"), curves))


def test_of_the_latest_arrival():
    gap = gap_of("makespan")
    assert gap.value == 9.0
    assert gap.least == pytest.approx(7.0)
    assert gap.gap == pytest.approx(2.0 / 6.0)
    assert gap.sentence == "all have arrived at 9.00 s, on no plan before 7.00 s (gap 33.3 %)"


def test_of_the_sum():
    gap = gap_of("arrivals")
    assert gap.value == 16.0
    assert gap.least == pytest.approx(4.0 + 7.0)
    assert gap.gap == pytest.approx(5.0 / 5.0)
    assert "add up to 16.00 s, on no plan to less than 11.00 s" in gap.sentence
    content = gap.as_dict()
    assert content["minimise"] == "arrivals"
    assert [one["agent"] for one in content["bound"]["agents"]] == ["sam", "ann"]
