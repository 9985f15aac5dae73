"""The comparison: its scenes, what is measured of motions, the rivals, its page."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from stplan import load_scene
from stplan.bench import comparison
from stplan.bench.comparison import Performance
from stplan.bench.comparison_table import csv_text, markdown_text
from stplan.bench.makespan import fastest, shortest_time
from stplan.bench.rivals.task import Motion, Task
from stplan.errors import UsageError
from stplan.scene import parse_scene
from stplan.world import build_free_space, check_scene_in_world

SCENES = Path(__file__).parents[2] / "scenes" / "comparison"
CROSSING = """
stplan: 1
horizon: 20
time_scale: 5
defaults: {radius: 0.4, max_speed: 1.5, max_acceleration: 3.0}
agents:
  - {id: east, start: [-4, 0.2], goal: [4, 0.2]}
  - {id: north, start: [0, -5], goal: [0, 5]}
"""
STRAIGHT = [
    np.array([[-4.0, 0.2, 0.0], [0.0, 0.2, 4.0], [4.0, 0.2, 6.0]]),
    np.array([[0.0, -5.0, 0.0], [0.0, 5.0, 10.0]]),
]


def crossing_task() -> Task:
    scene = parse_scene(CROSSING)
    ways = [curve[[0, -1], :2] for curve in STRAIGHT]
    return Task(scene, None, 1.5, 3.0, ways, STRAIGHT, 20.0)


@pytest.mark.parametrize("name", comparison.NAMES)
def test_scenes_are_there_and_all_agents_have_the_same_limits(name):
    scene = load_scene(SCENES / f"{name}.yaml")
    assert check_scene_in_world(scene, build_free_space(scene)) == []
    assert {(agent.max_speed, agent.max_acceleration) for agent in scene.agents} == {(1.5, 3.0)}


def test_agents_of_different_limits_are_refused():
    scene = parse_scene(CROSSING)
    slower = replace(scene.agents[0], max_speed=1.0)
    with pytest.raises(UsageError, match="same max_speed"):
        comparison.build_task(replace(scene, agents=(slower, scene.agents[1])))


def test_motions_are_measured_exactly():
    scene = parse_scene(CROSSING)
    blank = Performance("x", "y", 2)
    one = comparison.measured(blank, scene, None, Motion(STRAIGHT, np.array([True, True])), 1.0, "")
    assert one.arrived == 2
    assert one.makespan == 10.0
    assert one.length == pytest.approx(18.0)
    assert one.acceleration == pytest.approx(1.0 / 3.0)
    rested = comparison.greatest_acceleration(STRAIGHT[0], rests=True)
    assert rested == pytest.approx(2.0 / 1.0)  # It stops from 2 m/s within half of 2 s.
    # At t = 4 both are on x = 0, at 0.2 and -1; a little later they are nearest.
    times = np.linspace(4.0, 6.0, 200_001)
    nearest = np.hypot(2.0 * (times - 4.0), 0.2 - (times - 5.0)).min()
    assert one.clearance == pytest.approx(nearest - 0.8, abs=1e-6)
    late = comparison.measured(
        blank, scene, None, Motion(STRAIGHT, np.array([True, False])), 1.0, ""
    )
    assert late.arrived == 1
    assert np.isnan(late.makespan)


def test_the_shortest_time_is_that_of_a_trapezoid_or_a_triangle():
    east = parse_scene(CROSSING).agents[0]
    assert shortest_time(east) == pytest.approx(8 / 1.5 + 0.5)
    near = replace(east, goal=(-3.7, 0.2))
    assert shortest_time(near) == pytest.approx(2 * np.sqrt(0.3 / 3.0))


def test_nobody_is_much_slower_than_limits_of_motion_ask():
    scene = parse_scene(CROSSING)
    found = fastest(scene, progress=lambda line: None)
    assert found is not None
    assert found.plan.certificate.holds
    least = max(map(shortest_time, scene.agents))
    assert least < found.makespan < 1.1 * least


@pytest.mark.parametrize(
    ("planner", "drive"),
    [
        pytest.param(planner, drive, id=planner)
        for planner, package, drive in comparison.RIVALS
        if find_spec(package)
    ],
)
def test_rivals_solve_an_easy_crossing(planner, drive):
    one = comparison.rival_outcome(crossing_task(), "crossing", planner, drive)
    assert one.arrived == 2
    assert 10 / 1.5 - 0.2 < one.makespan < 20.0
    assert one.clearance > -0.1


def test_unknown_scenes_and_folders_are_refused(tmp_path):
    with pytest.raises(UsageError, match="no scene 'nowhere'"):
        comparison.compare_planners(SCENES, ["nowhere"], progress=print)
    with pytest.raises(UsageError, match="--scenes"):
        comparison.compare_planners(tmp_path, ["gap"], progress=print)


def test_the_page_names_who_arrived_and_who_was_not_run():
    ours = Performance("gap", comparison.OURS, 6, 6, 8.25, 50.5, 2.75, 0.0004, 12.0, "certified")
    rival = Performance("gap", comparison.RIVALS[0][0], 6, 3, seconds=1.0)
    page = markdown_text([ours, rival])
    assert "| **stplan** " in page
    assert "6 of 6" in page
    assert "8.25" in page
    assert "3 of 6" in page
    missing = page.split("Not installed, so not run: ")[1].splitlines()[0]
    assert all(planner in missing for planner, _, _ in comparison.RIVALS[1:])
    assert csv_text([ours, rival]).splitlines()[1].startswith("gap,stplan,6,6,8.25,")
