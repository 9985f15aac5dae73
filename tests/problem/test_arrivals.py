"""When agents would arrive if nobody were in their way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.problem.arrivals import free_arrival, sooner_horizon
from stplan.scene import parse_scene
from stplan.scene.horizon import least_duration
from stplan.scene.model import Agent, Scene

SCENE = """
stplan: 1
horizon: 90.0
agents:
- {id: sam, start: [0, 0], goal: [6, 8], start_time: 3.0, mass: 2.0, preferred_time: 11.0,
   weights: {arrival: 0.5, kinetic: 1.5}}
"""


def scene(**changes: object) -> Scene:
    parsed = parse_scene(SCENE)
    (sam,) = parsed.agents
    return replace(parsed, agents=(replace(sam, **changes),))


def sam(**changes: object) -> Agent:
    return scene(**changes).agents[0]


@pytest.mark.parametrize("preferred", [-50.0, 0.0, 11.0, 80.0])
def test_it_is_where_motion_and_lateness_together_cost_least(preferred: float) -> None:
    agent = sam(preferred_time=preferred)
    durations = np.linspace(0.5, 87.0, 200_001)
    cost = 1.5 * 0.5 * 2.0 * 100.0 / durations + 0.25 * (3.0 + durations - preferred) ** 2
    assert free_arrival(agent) == pytest.approx(3.0 + durations[cost.argmin()], abs=1e-3)


def test_who_does_not_mind_when_is_as_late_as_may_be() -> None:
    lazy = sam().weights
    assert free_arrival(sam(weights=replace(lazy, arrival=0.0))) == 90.0


def test_no_limit_is_broken_by_it() -> None:
    agent = sam(preferred_time=0.0, max_speed=1.25, max_acceleration=0.5)
    assert least_duration(agent, 10.0) == pytest.approx(8.0 + 2.5)
    assert least_duration(agent, 2.0) == pytest.approx(4.0)
    assert free_arrival(agent) > 3.0 + 8.0 + 2.5


def test_a_horizon_nobody_needs_is_not_searched() -> None:
    sooner = sooner_horizon(scene())
    assert sooner is not None
    assert free_arrival(sam()) < sooner < 90.0
    assert sooner_horizon(replace(scene(max_time=sooner), horizon=sooner)) is None
    later = sooner_horizon(replace(scene(max_time=400.0), horizon=400.0))
    assert later == pytest.approx(sooner)
    assert sooner_horizon(scene(weights=replace(sam().weights, arrival=0.0))) is None
