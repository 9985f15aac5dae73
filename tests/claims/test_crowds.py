"""Crowds: exits that are chosen, doors that are shared, rooms that empty in good time."""

from __future__ import annotations

import numpy as np
import pytest

from tests.claims.plans import curves, path_length, planned, straight_length

pytestmark = pytest.mark.claims


def test_a_hall_empties_by_both_exits(claim):
    """Agents with several exits take the one that is nearer, or freer"""
    ends = np.array([curve[-1, 0] for curve in curves("crowds/lecture-hall").values()])
    claim("lecture-hall", "share that leaves on the left", float((ends < 7.0).mean()),
          at_least=0.35, at_most=0.65)  # fmt: skip


def test_a_train_changes_its_passengers(claim):
    """Sixty who get off and sixty who get on share three doors"""
    found = curves("crowds/platform-exchange")
    boarded = [curve[-1, 1] < 2.6 for name, curve in found.items() if name.startswith("boarder")]
    claim("platform-exchange", "boarders in the train", sum(boarded), at_least=60.0)
    ways = [path_length(curve) / straight_length(curve) for curve in found.values()]
    claim("platform-exchange", "mean path over straight", float(np.mean(ways)), at_most=1.3)


def test_those_who_meet_in_a_corridor_hardly_leave_their_lines(claim):
    """Fifty each way pass each other in a corridor"""
    ways = [
        path_length(one) / straight_length(one) for one in curves("crowds/counterflow").values()
    ]
    claim("counterflow", "mean path over straight", float(np.mean(ways)), at_most=1.03)


def test_a_stand_empties_through_its_mouth(claim):
    """Two hundred leave through 3 m without going astray"""
    ways = [
        path_length(one) / straight_length(one) for one in curves("crowds/stadium-mouth").values()
    ]
    claim("stadium-mouth", "mean path over straight", float(np.mean(ways)), at_most=1.2)


def test_a_shop_is_walked_through_on_short_ways(claim):
    """Customers who come one after another see their shelf and leave"""
    found = curves("crowds/shop")
    ways = [
        path_length(found[agent.id]) / _by_way_of(agent, found[agent.id][-1])
        for agent in planned("crowds/shop").scene.agents
        if agent.waypoints
    ]
    claim("shop", "mean path over straight by way of the shelf", float(np.mean(ways)), at_most=1.15)


def _by_way_of(agent, end) -> float:
    """From start to `end` through the waypoints, m."""
    stops = np.array([agent.start, *agent.waypoints, end[:2]])
    return float(np.hypot(*np.diff(stops, axis=0).T).sum())


def test_a_room_is_left_as_fast_as_can_be(claim):
    """The latest of forty leaves as early as can be found"""
    gap = planned("crowds/evacuation").report.arrivals
    claim("evacuation", "latest arrival, s", gap.value, at_most=6.0)
    claim("evacuation", "latest arrival over its bound", gap.value / gap.least, at_most=1.6)
