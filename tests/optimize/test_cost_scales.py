"""Reports hold all it takes: every cost is computed anew from the written files alone."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import stplan
from stplan.optimize.whole import optimise_whole
from stplan.planner import write_plan
from stplan.scene import load_scene
from stplan.status import Status
from tests.optimize.recomputed import recomputed_costs
from tests.optimize.scenes import FAST, FRIENDS, MEET, ROOM, scene_text

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
    path.write_text(scene_text(given))
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
        found = optimise_whole(*args, **kwargs)
        moved = found.world_lines.knots + np.array([0.0, 0.1, 0.0])
        return replace(found, world_lines=found.world_lines.with_knots(moved))

    monkeypatch.setattr("stplan.planner.optimise_whole", displaced)
    path = tmp_path / "scene.yaml"
    path.write_text(scene_text(WALKS))
    plan = stplan.plan(load_scene(path))
    assert plan.status is Status.BROKEN
    write_plan(plan, tmp_path / "run")
    costs = json.loads((tmp_path / "run" / "report.json").read_text())["costs"]
    recomputed = recomputed_costs(tmp_path / "run")
    assert recomputed == {name: pytest.approx(cost, rel=1e-7) for name, cost in costs.items()}
