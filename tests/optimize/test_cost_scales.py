"""Reports hold all it takes: every cost is computed anew from the written files alone."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import stplan
from stplan.optimize.continuation import optimise
from stplan.planner import write_plan
from stplan.scene import load_scene
from stplan.status import Status
from tests.optimize.recomputed import recomputed_costs

SCENE = """
stplan: 1
horizon: 14.0
time_scale: 1.5
{map}
agents:
- {{id: sam, start: [0, 0], goal: [9, 0.2], mass: 3.0, radius: 0.4, {sam}
   weights: {{kinetic: 2.0, acceleration: 0.3, arrival: 0.5, collision: 2.0}}, preferred_time: 9.0}}
- {{id: ann, start: [9, 0.1], goal: [0, -0.3], radius: 0.3, after_arrival: vanish, {ann}
   weights: {{regularity: 0.02, wall: 2.5, collision: 0.5}}}}
- {{id: bus, path: [[4, -4, 0], [4.5, 4, 12]], radius: 0.5, after_arrival: vanish, weights: {{wall: 0}}}}
- {{id: eve, start: [1, 2], goal: [8, 2], max_time: 18.0, radius: 0.25, {eve}
   weights: {{collision: 0.0, wall: 0.0}}}}
{pairs}
solver: {{outer_iterations: 2, max_iterations: 25, {solver}}}
"""
ROOM = """
map:
  rectangle: [-1, -5, 10, 5]
  obstacles: [{rectangle: [3, -1.6, 3.4, -0.8]}, {rectangle: [6, 0.9, 7, 1.4]}]
"""
FRIENDS = "pairs: [{between: [sam, eve], grouping: 0.7}, {between: [ann, bus], distance: 1.1}]"
MEET = "pairs: [{between: [sam, eve], meet: {within: 1.2}}]"
FAST = {"sam": "max_speed: 0.97,", "ann": "max_acceleration: 0.5,", "eve": "max_speed: 0.45,"}


WALKS = {"map": ROOM, "pairs": FRIENDS, "solver": "clearance_model: smooth-minimum"}


@pytest.mark.parametrize(
    ("given", "terms"),
    [
        ({}, {"acceleration", "arrival", "collision"}),
        (
            {"map": ROOM, "pairs": FRIENDS},
            {"acceleration", "arrival", "collision", "wall", "grouping"},
        ),
        (
            WALKS,
            {"acceleration", "arrival", "collision", "wall", "grouping"},
        ),
        (
            {"map": ROOM, "solver": "barrier_range: 0.5, mu: 0.3"},
            {"acceleration", "arrival", "collision", "wall"},
        ),
        (
            {"map": ROOM, "solver": "barrier_range: .inf, clearance_model: smooth-minimum"},
            {"acceleration", "arrival", "collision", "wall"},
        ),
        (
            {"map": ROOM, "sam": "clearance: 0.1,", "ann": "clearance: 0.12,"},
            {"acceleration", "arrival", "collision", "wall", "pair clearance", "wall clearance"},
        ),
        (
            {"pairs": MEET, **FAST},
            {"acceleration", "arrival", "collision", "meeting", "speed limit", "acceleration limit"}
            | {"rest limit"},
        ),
    ],
)
def test_every_cost_is_recomputed_from_the_files(tmp_path, given, terms) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.format(**(dict.fromkeys(("map", "pairs", "solver", *FAST), "") | given)))
    plan = stplan.plan(load_scene(path))
    assert plan.exit_status == 0
    write_plan(plan, tmp_path / "run")
    costs = json.loads((tmp_path / "run" / "report.json").read_text())["costs"]
    assert set(costs) == {"kinetic", "regularity"} | terms
    recomputed = recomputed_costs(tmp_path / "run")
    assert set(recomputed) == set(costs)
    for name, cost in costs.items():
        assert recomputed[name] == pytest.approx(cost, rel=1e-7, abs=1e-12), name
    # Nothing of this is idle.
    assert all(costs[name] > 0.0 for name in terms)


def test_costs_of_a_broken_plan_are_those_of_its_initial_curves(tmp_path, monkeypatch) -> None:
    def displaced(*args, **kwargs):
        found = optimise(*args, **kwargs)
        moved = found.world_lines.knots + np.array([0.0, 0.1, 0.0])
        return replace(found, world_lines=found.world_lines.with_knots(moved))

    monkeypatch.setattr("stplan.planner.optimise", displaced)
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.format(**(dict.fromkeys(("map", "pairs", "solver", *FAST), "") | WALKS)))
    plan = stplan.plan(load_scene(path))
    assert plan.status is Status.BROKEN
    write_plan(plan, tmp_path / "run")
    costs = json.loads((tmp_path / "run" / "report.json").read_text())["costs"]
    recomputed = recomputed_costs(tmp_path / "run")
    assert recomputed == {name: pytest.approx(cost, rel=1e-7) for name, cost in costs.items()}
