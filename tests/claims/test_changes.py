"""Scenes in which something happens on the way: the past stays, and mending costs little."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from stplan import load_scene
from stplan.analysis.precedence import longest_delay, precedence
from stplan.multistart import own_cost
from stplan.planner import Plan
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.replanning.execution import plan
from stplan.scene.model import Robust
from tests.claims.plans import SCENES, curves, places


@cache
def undisturbed(name: str) -> Plan:
    """The plan of a shipped scene to which nothing happens."""
    return plan(replace(load_scene(SCENES / f"{name}.yaml"), changes=()))


def changed_knots(name: str, at: float) -> int:
    """Knots before `at` that are not to the byte what they were before anything happened."""
    lines = undisturbed(name).trajectories
    assert lines is not None
    old = dict(zip(lines.agent_ids, lines.curves(), strict=True))
    return sum(
        int((curve[curve[:, 2] < at] != old[who][old[who][:, 2] < at]).any(axis=1).sum())
        for who, curve in curves(name).items()
    )


def test_a_delay_is_forgiven_at_a_small_price(claim):
    """A robot breaks down for five seconds, and the others find their way around it"""
    name, found = "changes/late-robot", curves("changes/late-robot")
    stands = np.ptp(places(found["eve"], np.linspace(8.0, 13.0, 501)), axis=0).max()
    claim("late-robot", "how far it moves meanwhile, m", stands, at_most=1e-9)
    claim("late-robot", "knots of the past that changed", changed_knots(name, 8.0), at_most=0)
    lines = undisturbed(name).trajectories
    assert lines is not None
    costs = [total_kinetic_cost([1.0] * 4, list(c)) for c in (found.values(), lines.curves())]
    claim("late-robot", "energy over that without the delay", costs[0] / costs[1], at_most=1.12)


def test_a_closed_door_is_left_for_the_other(claim):
    """Who finds a door closed turns to the other one, and is there in time"""
    ann = curves("changes/closed-door")["ann"]
    times = np.linspace(ann[0, 2], ann[-1, 2], 4001)
    walked = places(ann, times)
    passes = walked[np.abs(walked[:, 1] - 5.0).argmin(), 0]
    claim("closed-door", "where ann passes the wall, x in m", passes, at_least=8.3, at_most=9.7)
    heading = ann[ann[:, 2] < 14.0][:, 0]
    claim("closed-door", "where she headed before, x in m", heading.max(), at_most=4.0)
    claim("closed-door", "knots of the past that changed",
          changed_knots("changes/closed-door", 14.0), at_most=0)  # fmt: skip


def test_whoever_crosses_before_a_tram_may_stop(claim):
    """Whoever crosses before a tram may stop for two seconds, at a small price"""
    robust = load_scene(SCENES / "changes/tram.yaml")
    careful, careless = (plan(replace(robust, robust=asked)) for asked in (robust.robust, Robust()))
    proven = [
        longest_delay(precedence(one.scene, one.trajectories or one.seed))
        for one in (careful, careless)
    ]
    claim("tram", "longest stop of any one agent that is survived, s", proven[0], at_least=2.0)
    claim("tram", "the same where nothing is asked, s", proven[1], at_most=1.9)
    costs = [own_cost(one.scene, one.trajectories or one.seed) for one in (careful, careless)]
    claim("tram", "energy over that where nothing is asked", costs[0] / costs[1], at_most=1.2)
