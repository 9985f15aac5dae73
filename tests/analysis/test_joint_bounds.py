"""What groups pay beyond what their agents pay alone: never more than a certified plan of them does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis import joint_bounds, queues
from stplan.analysis.cost_bound import cost_bound, least_costs
from stplan.analysis.shortest_trips import shortest_legs
from stplan.bench import families_tight as tight
from stplan.planner import plan, prepare
from stplan.scene import parse_scene

DOOR = """\
stplan: 1
horizon: 16.0
map:
  rectangle: [-4, 0, 4, 5]
  obstacles: [{rectangle: [-0.1, 0, 0.1, 2.1]}, {rectangle: [-0.1, 2.9, 0.1, 5]}]
defaults: {radius: 0.35, after_arrival: AFTER}
solver: {knots: 20, effort: quick, starts: 1}
seeding: {method: METHOD}
agents:
  - {id: a, start: [-3, 1], goal: [3, 1], mass: 2}
  - {id: b, start: [-3, 2.5], goal: [3, 2.5], start_time: 1.5}
  - {id: c, start: [-3, 4], goal: [3, 4], radius: 0.3}
  - {id: d, start: [2, 2.5], goal: [-2, 2.5], max_time: 14}
"""


def joint(scene):
    problem = prepare(scene)
    return joint_bounds.joint_bounds(problem, shortest_legs(problem), least_costs(problem))


@pytest.mark.parametrize("method", ["search", "relaxation", "dijkstra"])
@pytest.mark.parametrize("after", ["stay", "vanish"])
def test_plans_through_a_door_pay_more_than_the_bound(method, after):
    scene = parse_scene(DOOR.replace("METHOD", method).replace("AFTER", after))
    (queue,) = joint(scene)
    assert queue.kind == "gate"
    assert queue.agents.tolist() == [0, 1, 2, 3]
    assert queue.extra > 0.0
    assert queue.width == pytest.approx(0.8)
    assert abs(queue.place[0]) == pytest.approx(0.1)
    found = plan(scene)
    assert found.certificate.holds
    bound = found.report.bound
    assert bound.cost >= bound.total == pytest.approx(bound.least.sum() + queue.extra)


@pytest.mark.parametrize("seed", range(3))
def test_crowded_doors_are_bounded_better_and_never_above_a_plan(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    scene = tight.door(rng, per_side=5)
    scene = replace(scene, horizon=30.0)
    agents = tuple(replace(agent, max_time=30.0) for agent in scene.agents)
    scene = replace(
        scene, agents=agents, solver=replace(scene.solver, knots=20, effort="quick", starts=1)
    )
    found = plan(scene)
    bound = found.report.bound
    assert found.certificate.holds
    assert bound.least.sum() * 1.05 < bound.total <= bound.cost
    assert found.report.as_dict()["bound"]["together"][0]["agents"] == list(bound.agents)
    # If nobody could come nearer to the gate than four times as far, the plan would be impossible.
    asides = queues.least_asides
    monkeypatch.setattr(joint_bounds, "least_asides", lambda *own: 4.0 * asides(*own))
    mutated = cost_bound(prepare(scene), found.trajectories)
    assert mutated.total > mutated.cost


@pytest.mark.parametrize(
    "change",
    [
        "waypoints: [[-2, 2]]",
        "preferred_time: 9, weights: {arrival: 1}",
        "path: [[-3.6, 0.5, 0], [-3.6, 1, 14]]",
        "weights: {kinetic: 0}",
    ],
)
def test_who_is_not_even_paced_is_in_no_group(change):
    scene = DOOR.replace("METHOD", "auto").replace("AFTER", "stay")
    where = "start: [-3, 1], goal: [3, 1], mass: 2"
    motion = change if "path" in change else f"{where}, {change}"
    (queue,) = joint(parse_scene(scene.replace(where, motion)))
    assert queue.agents.tolist() == [1, 2, 3]


def test_pairs_that_need_not_keep_clear_are_not_queued():
    scene = DOOR.replace("METHOD", "auto").replace("AFTER", "stay")
    ignored = parse_scene(scene + "pairs: [{between: [a, b], collide: false}]\n")
    assert [queue.agents.tolist() for queue in joint(ignored)] == [[0, 2, 3]]
    apart = parse_scene(scene + "pairs: [{between: [a, b], distance: 0.05}]\n")
    assert all(0 not in queue.agents or 1 not in queue.agents for queue in joint(apart))


def test_the_open_has_no_doors():
    open_scene = parse_scene(
        "stplan: 1\nhorizon: 9\nagents: [{id: a, start: [0, 0], goal: [3, 0], radius: 0.3}]\n"
    )
    assert joint(open_scene) == ()
