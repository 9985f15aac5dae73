"""Robots with one task after another: all done, certified, and as fast as may be."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.play import certify_play
from stplan.errors import SeedingError, StoppedError, UsageError
from stplan.files.csv_file import csv_bytes
from stplan.files.json_file import json_bytes
from stplan.planned import Plan
from stplan.planner import improve, prepare
from stplan.problem.continuation import curves_of
from stplan.problem.world_lines import WorldLines
from stplan.replanning.execution import check, plan
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.world import build_free_space

# A ring of lanes that fit one, with a pocket for each robot.
RING = """
stplan: 1
name: ring
horizon: none
map:
  rectangle: [0, 0, 7, 4]
  obstacles: [{{rectangle: [1, 1, 4.6, 1.6]}}, {{rectangle: [1, 2.4, 4.6, 3]}}]
defaults: {{radius: 0.3, max_speed: 1}}
agents:
  - {{id: a, start: [6.5, 0.7]}}
  - {{id: b, start: [6.5, 2]}}
  - {{id: c, start: [6.5, 3.3]{goal}}}
tasks: {{points: [[0.5, 2], [2.8, 0.5], [2.8, 2], [2.8, 3.5]], service: 1, {tasks}}}
"""


def ring(tasks: str = "each: 3", goal: str = "") -> Scene:
    return parse_scene(RING.format(tasks=tasks, goal=goal))


@pytest.fixture(scope="module")
def worked() -> tuple[Scene, Plan]:
    scene = ring()
    return scene, plan(scene)


def test_everybody_does_its_tasks_and_goes_home(worked) -> None:
    scene, found = worked
    assert found.certificate.holds
    assert found.report.throughput.tasks == 9
    curves = curves_of(found.trajectories)
    for agent in scene.agents:
        assert tuple(curves[agent.id][-1, :2]) == agent.start
        for task in scene.tasks:
            if task.agent == agent.id:
                assert (curves[agent.id][:, :2] == task.at).all(axis=1).any()
    assert check(scene, found.trajectories).holds


def test_nobody_is_faster_than_its_bound(worked) -> None:
    _, found = worked
    figures = found.report.throughput
    assert 0.3 < figures.share <= 1.0
    assert figures.per_hour <= figures.bound
    for robot in figures.robots:
        assert robot.time >= robot.bound * (1.0 - 1e-9)


def test_a_certificate_misses_what_is_not_done(worked) -> None:
    scene, found = worked
    curves = curves_of(found.trajectories)
    end = float(curves["a"][-1, 2])
    idle = curves | {"a": np.array([[6.5, 0.7, 0.0], [6.5, 0.7, end]])}
    lines = WorldLines.from_curves(list(idle), list(idle.values()))
    broken = certify_play(scene, build_free_space(scene), lines).violations
    assert any("a: never stands at" in one and "3 tasks left" in one for one in broken)


def test_runs_repeat_to_the_byte(worked) -> None:
    scene, found = worked
    again = plan(ring())
    assert csv_bytes(again.trajectories) == csv_bytes(found.trajectories)
    assert json_bytes(again.report.as_dict()) == json_bytes(found.report.as_dict())
    assert scene.content_hash == ring().content_hash != ring("each: 4").content_hash


def test_who_is_in_the_way_of_the_next_goes_out_of_it() -> None:
    # Both go to the same two points in turn: each stands where the other is to go next.
    text = RING.format(tasks="each: 4", goal="").replace(
        "[[0.5, 2], [2.8, 0.5], [2.8, 2], [2.8, 3.5]]", "[[2.8, 0.5], [2.8, 2]]"
    )
    found = plan(parse_scene(text))
    assert found.certificate.holds
    assert found.report.throughput.tasks == 12


def test_a_goal_that_is_given_is_where_it_goes_in_the_end() -> None:
    found = plan(ring("each: 1", ", goal: [5.4, 2.7]"))
    assert tuple(curves_of(found.trajectories)["c"][-1, :2]) == (5.4, 2.7)


def test_shared_tasks_are_done_by_whoever_is_free() -> None:
    scene = ring("shared: 8")
    found = plan(scene)
    assert found.certificate.holds
    robots = found.report.throughput.robots
    assert sum(one.tasks for one in robots) == 8
    assert len(robots) > 1
    stays = WorldLines.from_curves(
        [agent.id for agent in scene.agents],
        [np.array([[*agent.start, 0.0], [*agent.start, 9.0]]) for agent in scene.agents],
    )
    broken = certify_play(scene, build_free_space(scene), stays).violations
    assert any("nobody does the task at" in one for one in broken)


def test_where_nobody_can_go_on_the_reason_is_said() -> None:
    text = RING.format(tasks="each: 1", goal="").replace("[0.5, 2], [2.8, 0.5], [2.8, 2], ", "")
    # b goes home to the only place of work.
    text = text.replace("start: [6.5, 2]}", "start: [6.5, 2], goal: [2.8, 3.5]}")
    with pytest.raises(SeedingError, match=r"nobody can go on: .* cannot get to \(2.8, 3.5\)"):
        plan(parse_scene(text))


def test_played_scenes_are_not_planned_otherwise(worked) -> None:
    scene, found = worked
    with pytest.raises(UsageError, match="tasks"):
        prepare(scene)
    with pytest.raises(UsageError, match="past improvement"):
        improve(found, None)  # type: ignore[arg-type]
    with pytest.raises(StoppedError):
        plan(scene, stop=lambda: True)
