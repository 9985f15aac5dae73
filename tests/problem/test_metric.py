"""The metric that is chosen where a scene states none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan import planner
from stplan.planner import plan
from stplan.problem import planning_problem
from stplan.problem.metric import (
    MOST_GROWTH,
    OPEN_SHARE,
    SEED_SHARE,
    WALLED_SHARE,
    sharpened,
    with_metric,
)
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.scene.model import Scene

HEAD = "stplan: 1\nhorizon: {horizon}\n{more}agents:\n"
SAM = "  - {id: sam, start: [0, 0], goal: [20, 0], radius: 0.5}\n"
ANN = "  - {id: ann, start: [20, 3], goal: [0, 3], radius: 0.5}\n"
WALL = "map: {rectangle: [-5, -9, 25, 9], obstacles: [{rectangle: [9, -9, 11, 7]}]}\n"


def scene(agents: str = SAM + ANN, more: str = "", horizon: float = 10.0) -> Scene:
    return parse_scene(HEAD.format(horizon=horizon, more=more) + agents)


def prepare(given: Scene) -> PlanningProblem:
    """In the frame of the scene itself."""
    return with_metric(planning_problem.prepare(given))


def test_the_metric_does_not_depend_on_the_frame():
    for more in ("", WALL):
        local, outside = planner.prepare(scene(more=more)), prepare(scene(more=more))
        assert local.frame.speed != 1.0
        assert local.written.scene.time_scale == pytest.approx(outside.time_scale, rel=1e-6)
        assert local.time_scale * local.frame.speed == pytest.approx(outside.time_scale, rel=1e-6)
        assert local.scene.turning_scale * local.frame.speed == pytest.approx(1.0)
    stated = planner.prepare(scene(more="time_scale: 0.3\n"))
    assert stated.scene.turning_scale * stated.frame.speed == pytest.approx(0.3)


def test_a_stated_metric_is_kept_and_one_that_is_not_follows_the_speeds():
    stated = prepare(scene(more="time_scale: 0.3\n"))
    assert (stated.time_scale, stated.scene.metric) == (0.3, "stated")
    assert stated.scene.turning_scale == 0.3
    free = prepare(scene())
    assert free.time_scale == pytest.approx(2.0 * OPEN_SHARE, rel=1e-6)
    assert free.scene.metric == "chosen"
    assert free.scene.turning_scale == 1.0
    # The longer way around a wall counts, and is hurried along.
    assert prepare(scene(more=WALL)).time_scale > 2.2 * WALLED_SHARE
    assert prepare(scene(more="time_scale: auto\n")).time_scale == free.time_scale
    # Once chosen it stays, whoever prepares the scene again.
    again = replace(free.scene, time_scale=7.0)
    assert prepare(again).time_scale == 7.0


def test_stating_the_former_default_leaves_hashes_as_they_were():
    plain, one = scene(), scene(more="time_scale: 1\n")
    assert one.content_hash != plain.content_hash
    assert one.metric == "stated"
    chosen = planning_problem.prepare(one).scene
    assert chosen.content_hash == one.content_hash


def test_the_same_scene_in_millimetres_is_the_same():
    small = SAM.replace("20, 0", "20000, 0").replace("0.5", "500")
    assert prepare(scene(small)).time_scale == pytest.approx(1000 * prepare(scene(SAM)).time_scale)


def test_starts_one_after_another_are_kept_apart():
    """In the metric that the speeds alone ask for, the second one would start inside the first one's rod."""
    late = SAM.replace("sam", "eve").replace("radius", "start_time: 0.12, radius")
    problem = prepare(
        scene(SAM.replace("goal: [20, 0]", "goal: [20, 0], after_arrival: vanish") + late)
    )
    assert problem.time_scale * 0.12 > 1.0
    assert problem.time_scale < 3.0 * 1.05 / 0.12


def test_starts_that_no_metric_keeps_apart_leave_it_as_it_is():
    beside = SAM.replace("sam", "eve").replace("start: [0, 0]", "start: [0.3, 0]")
    given = planning_problem.prepare(scene(SAM))
    assert prepare(scene(SAM)).time_scale == pytest.approx(2.0 * OPEN_SHARE, rel=1e-6)
    both = replace(given.scene, agents=(*given.scene.agents, *parse_agents(beside)))
    problem = prepare(both)
    assert problem.time_scale == pytest.approx(2.0 * OPEN_SHARE, rel=0.02)


def parse_agents(text: str):
    return scene(text).agents


def test_a_hurried_seed_asks_for_more_and_stays_clear():
    problem = prepare(scene())
    even = [np.array([[0, 0, 0], [20, 0, 10.0]]), np.array([[20, 3, 0], [0, 3, 10.0]])]
    lines = WorldLines.from_curves(problem.agent_ids, even)
    assert sharpened(problem, lines).time_scale == problem.time_scale
    hurried = [np.array([[0, 0, 0], [0.01, 0, 6.0], [20, 0, 10.0]]), even[1]]
    lines = WorldLines.from_curves(problem.agent_ids, hurried)
    sharp = sharpened(problem, lines)
    assert sharp.time_scale == pytest.approx(SEED_SHARE * 5.0, rel=0.1)
    assert not verify(sharp, hurried)
    sudden = [np.array([[0, 0, 0], [0.01, 0, 9.9], [20, 0, 10.0]]), even[1]]
    lines = WorldLines.from_curves(problem.agent_ids, sudden)
    assert sharpened(problem, lines).time_scale == pytest.approx(MOST_GROWTH * problem.time_scale)


def test_nobody_who_moves_needs_no_metric():
    still = "  - {id: sam, start: [0, 0], goal: [0, 0], radius: 0.5}\n"
    assert prepare(scene(still)).time_scale == 1.0


def test_friends_keep_the_metric_that_their_pull_is_measured_in():
    friends = "pairs: [{between: [sam, ann], grouping: 1.0}]\n"
    found = prepare(scene(more=friends))
    assert found.time_scale == pytest.approx(2.0, rel=1e-6)
    lines = WorldLines.from_curves(
        found.agent_ids, [np.array([[0, 0, 0], [20, 0, 1.0]]), np.array([[20, 3, 0], [0, 3, 1.0]])]
    )
    assert sharpened(found, lines) is found
    small = [
        one.replace("20", "20000").replace(" 3]", " 3000]").replace("0.5", "500")
        for one in (SAM, ANN)
    ]
    assert prepare(scene("".join(small), friends)).time_scale == pytest.approx(2000.0, rel=1e-6)


def test_a_convoy_goes_straight():
    """Fast cars, one behind the other: in the metric of 1 m/s their rods would overlap."""
    cars = "".join(
        f"  - {{id: car-{k}, start: [{20 * k}, 0], goal: [{20 * k + 150}, 0], radius: 2}}\n"
        for k in range(5)
    )
    found = plan(scene(cars))
    assert found.certificate.holds
    assert found.report.bound.excess < 1e-3
    assert found.report.as_dict()["scene"]["time_scale"] == found.scene.time_scale > 15.0
