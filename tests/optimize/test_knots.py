"""How many knots curves have hardly matters to what their plan costs, and less the more they are."""

from __future__ import annotations

import numpy as np
import pytest

import stplan
from stplan.analysis.own_costs import own_costs
from stplan.scene import parse_scene

PASSING = """
stplan: 1
horizon: 16.0
defaults: {radius: 0.3}
agents:
- {id: sam, start: [0, 0], goal: [9, 0.1], mass: 3}
- {id: ann, start: [9, 0], goal: [0, 0.2]}
"""
CORNER = """
stplan: 1
horizon: 20.0
map: {rectangle: [0, 0, 10, 8], obstacles: [{rectangle: [4, 0, 6, 4]}]}
agents:
- {id: sam, start: [2, 1], goal: [8, 1], radius: 0.4}
"""


@pytest.mark.parametrize("scene", [PASSING, CORNER], ids=["passing", "corner"])
def test_plans_cost_the_same_with_twice_the_knots(scene: str) -> None:
    costs = []
    for knots in (40, 80, 160):
        plan = stplan.plan(parse_scene(scene, overrides=[f"solver.knots={knots}"]))
        assert plan.trajectories is not None
        costs.append(own_costs(plan.scene, plan.trajectories).sum())
    change = np.abs(np.diff(costs)) / costs[-1]
    assert change[1] <= 1e-3
    assert change[0] <= 5e-3
