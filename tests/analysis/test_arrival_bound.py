"""Bounds of arrivals: reached by who hurries alone, and never later than any certified arrival."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.analysis.arrival_bound import arrival_bound
from stplan.bench import families_open as wide
from stplan.planner import plan, prepare
from stplan.scene import parse_scene

SCENE = """\
stplan: 1
horizon: 40.0
map: {{rectangle: [-9, -9, 9, 9], obstacles: [{{rectangle: [-1, -9, 1, 1]}}]}}
agents:
  - {{id: sam, start: [-4, 0], goal: [4, 0], start_time: 2.0, {more}}}
  - {{id: ann, path: [[0, 5, 0], [3, 5, 7]], radius: 0.5}}
"""
# From (-4, 0) around two corners of radius 0.5 at (-1, 1) and (1, 1).
WAY = 2.0 * (np.sqrt(10.0 - 0.25) + 0.5 * (np.arctan2(1.0, 3.0) + np.arcsin(0.5 / np.sqrt(10.0))))
WAY += 2.0


@pytest.mark.parametrize(
    ("more", "earliest"),
    [
        ("radius: 0.5, max_speed: 1.6", 2.0 + WAY / 1.6),
        ("radius: 0.5, max_acceleration: 0.5", 2.0 + np.sqrt(2.0 * WAY / 0.5)),
        (
            "radius: 0.5, max_speed: 1.6, waypoints: [{at: [0, 3], window: [15, 26], dwell: 4}]",
            19.0 + 4.9 / 1.6,
        ),
        ("radius: 0.5", 2.0),
    ],
    ids=["speed", "acceleration", "visit", "free"],
)
def test_nobody_arrives_before_its_shortest_way_lets_it(more, earliest):
    scene = parse_scene(SCENE.format(more=more))
    bound = arrival_bound(prepare(scene))
    assert bound.agents == ("sam", "ann")
    assert bound.earliest[0] == pytest.approx(earliest, rel=2e-2)
    assert bound.earliest[1] == pytest.approx(7.0)
    assert bound.makespan == max(bound.earliest)
    assert bound.total == pytest.approx(bound.earliest.sum())
    rows = bound.as_dict()["agents"]
    assert [row["earliest"] for row in rows] == bound.earliest.tolist()


def test_hurried_plans_come_near_their_bound_and_not_below():
    scene = wide.circle(4, 3.0, 20.0, radius=0.3)
    agents = [
        f"{{id: a{k}, start: [{a.start[0]}, {a.start[1]}], goal: [{a.goal[0]}, {a.goal[1]}], radius: 0.3, "
        "max_speed: 1.5, preferred_time: 1.0, weights: {arrival: 50.0}}"
        for k, a in enumerate(scene.agents)
    ]
    scene = parse_scene(
        "stplan: 1\nhorizon: 12.0\nsolver: {effort: quick, knots: 25}\nagents:\n  - "
        + "\n  - ".join(agents)
    )
    found = plan(scene)
    arrivals = np.array([curve[-1, 2] for curve in found.trajectories.curves()])
    bound = arrival_bound(prepare(scene))
    assert np.all(arrivals >= bound.earliest)
    assert bound.makespan == pytest.approx(4.0, rel=1e-6)
    assert arrivals.max() <= 1.5 * bound.makespan
