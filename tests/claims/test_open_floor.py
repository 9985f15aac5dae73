"""Circles, stand-offs and the meadow: what happens where there is room."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest

from stplan.planner import plan
from stplan.scene import parse_scene
from tests.claims.plans import (
    close_calls,
    curves,
    deviation,
    nearest,
    offsets,
    path_length,
    planned,
    straight_length,
    turned,
)

SMALL, LARGE = (2, 5, 8, 10), (15, 20, 25, 30, 35)
CIRCLES = [*SMALL, *(pytest.param(count, marks=pytest.mark.claims) for count in LARGE)]


@pytest.mark.parametrize("count", CIRCLES)
def test_circles_are_crossed_without_spinning(count, claim):
    """Agents take "smooth, natural trajectories rather than the strange spinning motions"."""
    name, found = f"circle-{count}", curves(f"circle/circle-{count}").values()
    pairs = count * (count - 1) // 2
    assert close_calls(f"circle/circle-{count}") == pairs
    claim(name, "most turning of an agent, degrees", max(map(turned, found)), at_most=90)
    longest = max(path_length(own) / straight_length(own) for own in found)
    claim(name, "longest path over straight", longest, at_most=1.02)
    ratio = planned(f"circle/circle-{count}").report.metrics.kinetic_over_straight
    assert ratio is not None
    claim(name, "kinetic energy over its bound", ratio, at_most=1.02)


def test_paths_start_to_give_way_long_before(claim):
    """Planning "globally in space and time" gives smooth anticipatory trajectories."""
    found = curves("three-agents/mass")
    ann, sam = found["ann"], found["sam"]
    times = np.linspace(0.0, 12.0, 1201)
    closest = times[_distance(ann, sam, times).argmin()]
    aside = np.interp(times, ann[:, 2], np.abs(offsets(ann)))
    first = times[np.flatnonzero(aside > 0.1 * deviation(ann))[0]]
    claim("three-agents-mass", "giving way before the closest moment, s", closest - first,
          at_least=2)  # fmt: skip


def _distance(first: np.ndarray, second: np.ndarray, times: np.ndarray) -> np.ndarray:
    gaps = [
        np.interp(times, first[:, 2], first[:, axis])
        - np.interp(times, second[:, 2], second[:, axis])
        for axis in range(2)
    ]
    return np.hypot(*gaps)


# Search has no random numbers to break a tie with.
STAND_OFF = """
stplan: 1
horizon: 14
seeding: {{method: search}}
defaults: {{radius: 0.75, after_arrival: vanish}}
agents:
  - {{id: sam, start: {0}, goal: {1}}}
  - {{id: ann, start: {2}, goal: {3}}}
  - {{id: ben, start: {4}, goal: {5}}}
"""
PLACES = [(-8, 0), (8, 0), (8, 1), (-8, 1), (8, -1), (-8, -1)]
Point = tuple[float, float]


def _energy(moved: Callable[[Point], Point]) -> float:
    text = STAND_OFF.format(*(list(map(float, moved(place))) for place in PLACES))
    result = plan(parse_scene(text))
    assert result.exit_status == 0
    ratio = result.report.metrics.kinetic_over_straight
    assert ratio is not None
    return ratio


def test_a_symmetric_stand_off_resolves_without_jitter(claim):
    """Unnaturally symmetric alignments are solved "without the need for jittering"."""
    original = _energy(lambda place: place)
    claim("stand-off", "kinetic energy over its bound", original, at_most=1.02)
    variants = {
        "mirrored": lambda place: (place[0], -place[1]),
        "turned by 90 degrees": lambda place: (-place[1], place[0]),
        "turned by 180 degrees": lambda place: (-place[0], -place[1]),
    }
    for name, moved in variants.items():
        claim("stand-off", f"change of that energy when {name}", abs(_energy(moved) / original - 1),
              at_most=0.02)  # fmt: skip


@pytest.mark.claims
def test_the_meadow_is_crossed_with_real_conflicts(claim):
    """102 people go to opposite sides of a meadow "while a couple of deer avoid them"."""
    found = curves("meadow/meadow")
    assert close_calls("meadow/meadow") >= 100
    ratio = planned("meadow/meadow").report.metrics.kinetic_over_straight
    claim("meadow", "kinetic energy over its bound", ratio, at_most=1.01)
    people = [deviation(own) for name, own in found.items() if name not in ("doe", "buck")]
    deer = [path_length(found[name]) / straight_length(found[name]) for name in ("doe", "buck")]
    claim("meadow", "median detour of people, m", float(np.median(people)), at_most=1.0)
    claim("meadow", "longest path of a deer over straight", max(deer), at_most=1.1)
    least = min(
        nearest(found[deer], own)
        for deer in ("doe", "buck")
        for name, own in found.items()
        if name not in ("doe", "buck")
    )
    claim("meadow", "nearest that deer and people come, m", least, at_least=2.0)


def test_one_path_of_all_costs_least(claim):
    """Of all paths to a goal "a straight line from start to end" costs least."""
    agents = planned("paths/utility").report.metrics.agents
    energy = {one.agent: one.kinetic_energy for one in agents}
    cheapest = min(energy["c1"], energy["c2"]) / energy["c3"]
    claim(
        "paths-utility", "energy of the given paths over the planned one", cheapest, at_least=1.05
    )
    claim("paths-utility", "planned path over straight",
          path_length(curves("paths/utility")["c3"]) / 10.0, at_most=1.001)  # fmt: skip


CROSSING = """
stplan: 1
horizon: 10
defaults: {radius: 0.3, after_arrival: vanish}
agents:
  - {id: east, start: [-6, 0], goal: [6, 0]}
  - {id: north, start: [0, -6], goal: [0, 6], start_time: 3}
"""


def test_rods_that_do_not_meet_are_agents_that_do_not(claim):
    """Two paths may cross on the ground: no collision "as long as no two rods are intersecting"."""
    result = plan(parse_scene(CROSSING))
    assert result.trajectories is not None
    # Their paths cross; as their rods do not, nobody has a reason to leave its straight line.
    aside = max(deviation(own) for own in result.trajectories.curves())
    claim("crossing", "largest deviation from straight, m", aside, at_most=0.01)


def test_everyone_meets_everyone_in_a_circle():
    pairs = list(combinations(range(8), 2))
    assert close_calls("circle/circle-8-small") == len(pairs)
