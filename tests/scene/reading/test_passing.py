"""Waypoints that are places: where in them agents pass."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import SceneError
from stplan.planner import plan
from stplan.scene import parse_scene

SCENE = """\
stplan: 1
horizon: 30
map: {{rectangle: [0, 0, 12, 8], obstacles: [{{rectangle: [5, 3, 7, 5]}}]}}
places:
  counter: {{rectangle: [4, 6, 8, 8]}}
  gate: {{line: [[3, 0], [3, 8]]}}
  beside: {{rectangle: [4.5, 3.5, 5, 4.5]}}
  pillar: {{rectangle: [5, 3, 7, 5]}}
  exit: {{line: [[11, 1], [11, 7]]}}
agents:
  - {{id: sam, start: [1, 2], goal: {goal}, radius: 0.3, waypoints: {waypoints}}}
"""


def waypoints_of(waypoints: str, goal: str = "[11, 2]"):
    return parse_scene(SCENE.format(waypoints=waypoints, goal=goal)).agents[0].waypoints


def test_the_point_nearest_to_the_straight_way_is_passed():
    ((x, y),) = waypoints_of("[{place: counter}]")
    assert 4.0 <= x <= 8.0
    assert y == pytest.approx(6.0)
    (crossed,) = waypoints_of("[{place: gate}]", goal="[11, 6]")
    assert crossed == pytest.approx((3.0, 2.0 + 4.0 * 2.0 / 10.0))


def test_what_comes_after_counts_and_so_do_walls():
    first, second = waypoints_of("[{place: gate, dwell: 2}, [2, 7]]")
    assert first[0] == 3.0
    # From (1, 2) to (2, 7): the end of that way is nearest to the line.
    assert first[1] == pytest.approx(7.0)
    assert second == (2.0, 7.0)
    # Beside the pillar, but no nearer to it than its radius.
    ((x, y),) = waypoints_of("[{place: beside}]", goal="[11, 6]")
    assert 4.5 <= x <= 5.0 - 0.3
    assert 3.5 <= y <= 4.5
    by_exit = waypoints_of("[{place: gate}]", goal="{place: exit}")
    assert by_exit[0] == pytest.approx((3.0, 2.0))


def test_plans_pass_the_place_as_long_as_they_are_asked_to():
    text = SCENE.format(waypoints="[{place: counter, window: [8, 14], dwell: 3}]", goal="[11, 2]")
    found = plan(parse_scene(text))
    assert found.certificate.holds
    curve = found.trajectories.curve(0)
    inside = curve[curve[:, 1] >= 6.0 - 1e-6, 2]
    assert np.ptp(inside) >= 3.0 - 1e-6
    assert inside.min() >= 8.0 - 1e-6
    assert inside.max() <= 14.0 + 1e-6


@pytest.mark.parametrize(
    ("waypoints", "message"),
    [
        ("[{place: pillar}]", "place pillar, which has no point that a disc of 0.3 m can stand on"),
        (
            "[{place: bar}]",
            "agents[0].waypoints[0].place: is 'bar', which is none of the scene's places",
        ),
        ("[[1, 1], {place: gate, at: [1, 1]}]", "agents[0].waypoints[1]: has both at and place"),
        (
            "[{dwell: 1}]",
            "agents[0].waypoints[0].at: is missing; a point [x, y] in m is expected, or a place",
        ),
    ],
)
def test_what_cannot_be_passed_is_refused(waypoints, message):
    with pytest.raises(SceneError) as refused:
        waypoints_of(waypoints)
    assert message in "\n".join(refused.value.messages)


def test_defaults_may_hold_them_too():
    text = SCENE.format(waypoints="[{place: gate}]", goal="[11, 6]")
    shared = text.replace(", waypoints: [{place: gate}]", "").replace(
        "agents:\n", "defaults: {waypoints: [{place: gate}]}\nagents:\n"
    )
    assert parse_scene(shared).agents[0].waypoints == parse_scene(text).agents[0].waypoints
    with pytest.raises(SceneError, match=r"defaults.waypoints\[0\].place"):
        parse_scene(shared.replace("place: gate", "place: pillar"))
