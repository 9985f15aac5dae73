"""Agents that start in motion."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import SeedingError
from stplan.improvement.budget import ImprovementBudget
from stplan.planner import improve, plan, prepare
from stplan.problem.launches import Launches
from stplan.scene import parse_scene

CROSSING = """
stplan: 1
horizon: 12
agents:
  - {id: a, start: [0, 0], goal: [8, 0], start_velocity: [0, 1.0]}
  - {id: b, start: [8, 0.5], goal: [0, 0.2], start_velocity: [-0.5, 0], max_acceleration: 0.6, max_speed: 1.5}
  - {id: c, start: [4, -4], goal: [4, 4]}
  - {id: d, start: [4, 4], goal: [4, -4], start_velocity: [1.0, 0], weights: {acceleration: 0.5}}
"""


def facing(gap: float) -> str:
    """Two that run into each other, `gap` m apart; and one beside a wall, running at it."""
    return f"""
stplan: 1
horizon: 10
map: {{rectangle: [-2, -3, 9, 3]}}
agents:
  - {{id: a, start: [0, 0], goal: [8, 0], start_velocity: [2, 0]}}
  - {{id: b, start: [{0.6 + gap}, 0], goal: [0, 1], start_velocity: [-2, 0]}}
  - {{id: c, start: [4, -2], goal: [4, 2], start_velocity: [0, -3]}}
"""


def test_plans_begin_in_motion_and_stay_so_when_improved() -> None:
    found = plan(parse_scene(CROSSING))
    assert found.certificate.holds
    assert found.exit_status == 0
    for result in (found, improve(found, ImprovementBudget(moves=4))):
        assert result.trajectories is not None
        assert result.certificate.holds
        curves = result.trajectories.curves()
        for agent, curve in zip(result.scene.agents, curves, strict=True):
            if agent.start_velocity is not None and agent.max_acceleration is None:
                step = curve[1] - curve[0]
                np.testing.assert_allclose(step[:2] / step[2], agent.start_velocity, atol=1e-9)


def test_a_walker_that_heads_the_other_way_turns_within_its_acceleration() -> None:
    text = """
stplan: 1
horizon: 14
agents:
  - {id: a, start: [0, 0], goal: [6, 0], start_velocity: [-1.0, 0], max_acceleration: 0.5}
"""
    found = plan(parse_scene(text))
    assert found.certificate.holds
    assert found.trajectories is not None
    # To stop from 1 m/s at 0.5 m/s^2 takes a metre: no plan turns any sooner, but for the first knots.
    assert found.trajectories.knots[:, 0].min() < -0.8


def test_launches_are_shortened_until_they_are_clear() -> None:
    problem = prepare(parse_scene(facing(0.4)))
    launches = Launches.of(problem)
    assert launches is not None
    lasts = {
        a: problem.frame.time * float(np.diff(piece[:, 2])[0])
        for a, piece in launches.pieces.items()
    }
    assert lasts[0] < 0.1
    assert 4 * lasts[0] > 0.05
    assert lasts[2] < 0.7 / 3
    whole, rest = launches.whole, launches.problem
    assert rest.num_agents == 6
    assert not rest.collides[0, 3]
    assert rest.collides[0, 1]
    assert rest.collides[0, 4]
    curves = [np.vstack([start, goal]) for start, goal in zip(
        np.column_stack([rest.starts, rest.start_times]),
        np.column_stack([rest.goals, rest.max_times]), strict=True)]  # fmt: skip
    joined = launches.joined(curves)
    assert len(joined) == whole.num_agents
    assert tuple(joined[0][0, :2]) == tuple(whole.starts[0])
    parted = launches.parted(joined)
    for one, other in zip(parted[:3], curves[:3], strict=True):
        np.testing.assert_array_equal(one, other)
    assert [launches.owner(name) for name in rest.agent_ids] == ["a", "b", "c", "a", "b", "c"]


def test_plans_begin_clear_of_what_they_run_at() -> None:
    found = plan(parse_scene(facing(0.4)))
    assert found.certificate.holds


def test_who_can_only_touch_is_refused() -> None:
    with pytest.raises(SeedingError) as caught:
        plan(parse_scene(facing(1e-12)))
    assert {name for reason in caught.value.reasons for name in reason.agents} >= {"a", "b"}
