"""Short motions keep the limits as the certificate judges them, and end at rest."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.motion import motion_peaks
from stplan.replanning.motions import Limits, arrivals, fan
from stplan.scene import parse_scene

STEP = 0.125
AGENT = parse_scene(
    """
stplan: 1
horizon: 9
agents: [{id: a, start: [0, 0], goal: [1, 0], max_speed: 2, max_acceleration: 3}]
"""
).agents[0]
LIMITS = Limits(2.0, 3.0, STEP)


def holds(velocities: np.ndarray) -> bool:
    """Whether a motion from rest, at velocities (n, 2), keeps the limits."""
    places = np.vstack([np.zeros(2), STEP * np.cumsum(velocities, axis=0)])
    curve = np.column_stack([places, STEP * np.arange(len(places))])
    return all(peak.holds for peak in motion_peaks(AGENT, curve))


def test_a_fan_keeps_the_limits_from_rest() -> None:
    found = fan(LIMITS, np.zeros(2), np.array([1.0, 1.0]), (4, 8), first=True)
    assert (found[:, -1] == 0.0).all()
    assert all(holds(motion) for motion in found)
    assert np.hypot(*found.reshape(-1, 2).T).max() == pytest.approx(2.0, rel=1e-6)


def test_a_fan_goes_on_from_any_velocity() -> None:
    """What was executed of one motion and another from there are one motion that keeps the limits."""
    rng = np.random.default_rng(2)
    for first in fan(LIMITS, np.zeros(2), np.array([0.0, 1.0]), (4, 8), first=True)[::7]:
        begun = first[:4]
        for motion in fan(LIMITS, begun[-1], rng.normal(size=2), (4, 8), first=False):
            assert (motion[-1] == 0.0).all()
            assert holds(np.vstack([begun, motion]))


def test_whoever_has_no_limit_of_acceleration_stops_at_once() -> None:
    found = fan(
        Limits(2.0, np.inf, STEP), np.array([2.0, 0.0]), np.array([1.0, 0.0]), (4,), first=False
    )
    assert (found[0] == 0.0).all()
    assert (found[:, 4:] == 0.0).all()
    assert np.hypot(*found[1, 0]) == pytest.approx(2.0, rel=1e-6)


def test_arrivals_end_on_the_goal_to_the_bit_within_the_limits() -> None:
    goal = np.array([0.7, 0.3])
    found = arrivals(LIMITS, np.zeros(2), np.zeros(2), goal, 40, first=True)
    assert found
    lengths = [len(points) for points in found]
    assert lengths == sorted(lengths)
    for points in found:
        assert (points[-1] == goal).all()
        places = np.vstack([np.zeros(2), points, goal])
        assert holds(np.diff(places, axis=0) / STEP)


def test_nobody_arrives_quicker_than_it_can() -> None:
    assert not arrivals(LIMITS, np.zeros(2), np.zeros(2), np.array([3.0, 0.0]), 8, first=True)
