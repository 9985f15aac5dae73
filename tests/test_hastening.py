"""Plans as fast as can be: near their bounds, certified, within all that the scene asks."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stplan.certify.certificate import certify
from stplan.files.json_file import json_bytes
from stplan.hastening import arrivals_of, lateness
from stplan.planner import Plan, check, plan
from stplan.scene import parse_scene
from stplan.world import build_free_space

CROSSING = """\
stplan: 1
minimise: {minimise}
horizon: auto
defaults: {{max_speed: 1.5{more}}}
agents:
  - {{id: a, start: [0, 0], goal: [6, 0]}}
  - {{id: b, start: [3, -3], goal: [3, 3]}}
  - {{id: c, start: [6, 1], goal: [0, 1.2]}}
"""
ROOM = """\
stplan: 1
minimise: {minimise}
horizon: {horizon}
defaults: {{radius: 0.2, after_arrival: vanish, max_speed: 1.3}}
map:
  rectangle: [0, 0, 5.2, 3]
  obstacles: [{{rectangle: [3, 0, 3.2, 0.9]}}, {{rectangle: [3, 2.1, 3.2, 3]}}]
places: {{exit: {{line: [[3.7, 0], [3.7, 3]]}}}}
agents:
  - {{id: p, count: 8, start: {{rectangle: [1, 0.5, 3, 2.5]}}, goal: {{place: exit}}}}
"""


@cache
def planned(text: str) -> Plan:
    found = plan(parse_scene(text))
    assert found.exit_status == 0
    assert found.certificate.holds
    return found


def arrivals(found: Plan) -> np.ndarray:
    return arrivals_of(found.trajectories)


@pytest.mark.parametrize("minimise", ["arrivals", "makespan"])
def test_in_the_open_plans_are_nearly_as_fast_as_if_nobody_else_were_there(minimise):
    found = planned(CROSSING.format(minimise=minimise, more=""))
    gap = found.report.arrivals
    assert gap.minimise == minimise
    assert gap.bound.makespan == pytest.approx(np.hypot(6, 0.2) / 1.5, rel=1e-6)
    assert 0.0 <= gap.gap < 0.06
    fastest = max(one.greatest_speed for one in found.report.metrics.agents)
    assert 1.4 < fastest <= 1.5


def test_the_horizon_that_was_open_is_that_of_the_latest_arrival():
    text = CROSSING.format(minimise="makespan", more="")
    found = planned(text)
    report = json.loads(json_bytes(found.report.as_dict()))
    latest = arrivals(found).max()
    assert report["scene"]["horizon"] == found.scene.horizon == latest
    assert report["arrivals"]["value"] == latest
    assert "bound" not in report
    # The file still leaves it open; the trajectories are what they were certified as.
    assert check(parse_scene(text), found.trajectories).holds
    assert certify(found.scene, None, found.trajectories).holds


def test_those_who_stop_at_the_end_take_longer():
    text = CROSSING.replace("  - {{id: c, start: [6, 1], goal: [0, 1.2]}}\n", "")
    quick = planned(text.format(minimise="makespan", more=""))
    slow = planned(text.format(minimise="makespan", more=", max_acceleration: 1"))
    # From rest to rest 6 m take 6 / 1.5 s and 1.5 / 1 s.
    assert arrivals(slow).max() >= 5.5 > arrivals(quick).max()
    assert slow.report.arrivals.gap < 0.5


def test_a_room_is_left_early_within_a_stated_horizon_or_not():
    stated = planned(ROOM.format(minimise="makespan", horizon=20))
    open_ended = planned(ROOM.format(minimise="makespan", horizon="auto"))
    for found in (stated, open_ended):
        assert found.report.arrivals.gap < 0.25
    assert stated.scene.horizon == 20.0
    assert "horizon" not in stated.report.as_dict()["scene"]


def test_what_is_least_is_what_was_asked_for():
    total = planned(ROOM.format(minimise="arrivals", horizon="auto"))
    latest = planned(ROOM.format(minimise="makespan", horizon="auto"))
    assert arrivals(total).sum() <= 1.02 * arrivals(latest).sum()
    assert arrivals(latest).max() <= 1.02 * arrivals(total).max()
    energy = planned(ROOM.format(minimise="energy", horizon=20))
    assert arrivals(energy).sum() > 2.0 * arrivals(total).sum()


def test_windows_and_dwells_are_kept():
    text = CROSSING.format(minimise="arrivals", more="").replace(
        "goal: [3, 3]}", "goal: [3, 3], waypoints: [{at: [3, 1], window: [5, 9], dwell: 1}]}"
    )
    found = planned(text)
    # Not before it may leave its waypoint, and little later.
    assert 6.0 + 2.0 / 1.5 <= arrivals(found)[1] < 7.7
    assert arrivals(found)[0] < 4.4


def test_quick_effort_makes_fewer_passes():
    scene = parse_scene(ROOM.format(minimise="makespan", horizon="auto"))
    lines: list[str] = []
    quick = plan(
        replace(scene, solver=replace(scene.solver, effort="quick")), progress=lines.append
    )
    assert sum(line.startswith("pass ") for line in lines) <= 2
    normal = planned(ROOM.format(minimise="makespan", horizon="auto"))
    assert arrivals(normal).max() <= arrivals(quick).max()


def test_stopped_it_keeps_what_it_has():
    scene = parse_scene(ROOM.format(minimise="makespan", horizon="auto"))
    answers = iter([False] * 30)
    found = plan(scene, stop=lambda: next(answers, True))
    assert found.exit_status == 130
    assert found.certificate.holds
    assert certify(found.scene, build_free_space(found.scene), found.trajectories).holds


def test_lateness_counts_from_the_starts():
    starts, ends = np.array([1.0, 2.0]), np.array([4.0, 9.0])
    assert lateness("makespan", starts, ends) == 8.0
    assert lateness("arrivals", starts, ends) == 10.0
