"""Large-neighbourhood search as it goes in crowds, tried on few agents."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.callbacks import never
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.verification import verify
from stplan.scene.model import Scene
from stplan.seeding.search import large_neighbourhood
from stplan.seeding.search.large_neighbourhood import first_curves, replan_neighbourhoods
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.planner import LayeredPlanner
from stplan.world import build_free_space

SCENES = {
    "warehouse": tight.warehouse(np.random.default_rng(2), robots=16),
    "pillars": tight.pillars(np.random.default_rng(1), agents=16),
    "door": tight.door(np.random.default_rng(3), per_side=4),
}


def planner_of(scene: Scene) -> LayeredPlanner:
    problem = PlanningProblem.from_scene(scene, build_free_space(scene))
    return Levels(problem).at(scene.seeding.margin).planner(1)


@pytest.mark.parametrize("name", SCENES)
def test_crowds_are_parted(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(large_neighbourhood, "CROWD", 2)
    planner = planner_of(SCENES[name])
    found = []
    for _ in range(2):
        rng = np.random.default_rng(0)
        curves = first_curves(planner, rng)
        assert curves is not None
        found.append(replan_neighbourhoods(planner, curves, rng, 600, never))
    assert found[0].clear
    assert not verify(planner.problem, found[0].curves, planner.required)
    again = zip(found[0].curves, found[1].curves, strict=True)
    assert all(np.array_equal(one, other) for one, other in again)
