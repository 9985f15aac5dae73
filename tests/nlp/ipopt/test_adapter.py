"""Ipopt's own barrier is not felt where runs end: latest arrivals are reached."""

from __future__ import annotations

import json

import numpy as np
import pytest

import stplan
from stplan.analysis.own_costs import own_costs
from stplan.scene import parse_scene

# Lanes of walkers that never meet, the last as dear as a lorry.
LANES = {
    "one": [{"start": [0, 0], "goal": [10, 4]}],
    "unequal": [
        {"start": [0, 0], "goal": [10, 4], "mass": 0.5},
        {"start": [0, 9], "goal": [1, 9], "max_time": 12},
        {"start": [0, 18], "goal": [10, 18], "mass": 2000},
    ],
}


@pytest.mark.parametrize("lanes", LANES)
@pytest.mark.parametrize("wall", [False, True])
def test_agents_alone_end_on_their_straight_line(lanes: str, wall: bool) -> None:
    agents = [{"id": f"a{k}", **agent} for k, agent in enumerate(LANES[lanes])]
    content = {"stplan": 1, "horizon": 20, "agents": agents}
    if wall:
        content["map"] = {"rectangle": [-2, -2, 12, 22]}
    scene = parse_scene(json.dumps(content))
    plan = stplan.plan(scene)
    assert plan.trajectories is not None
    for agent, cost in zip(scene.agents, own_costs(scene, plan.trajectories), strict=True):
        way = np.hypot(*(np.array(agent.goal) - agent.start))
        least = 0.5 * agent.mass * way**2 / (agent.max_time - agent.start_time)
        assert least * (1.0 - 1e-12) <= cost <= least * (1.0 + 1e-6), agent.id
