"""Groups, meetings, limits of motion and visits: what they mean and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.scene import parse_scene, scene_interactions
from stplan.scene.interactions import scene_meetings
from stplan.scene.model import Meet, Visit
from tests.scene.samples import PAIR, edited, refusals

THREE = PAIR + "  - {id: bob, start: [0, -5], goal: [10, -5], radius: 0.5}\n"


def test_groups_share_settings_and_pairs_win():
    scene = parse_scene(
        THREE + "groups:\n  - {name: walkers, members: [sam, bob], grouping: 2.0, distance: 1.5}\n"
        "pairs:\n  - {between: [walkers, ann], distance: 2.0}\n"
        "  - {between: [sam, bob], distance: 1.2}\n"
    )
    found = scene_interactions(scene)
    assert np.argwhere(found.grouping).tolist() == [[0, 2], [2, 0]]
    assert found.distance[0, 1:].tolist() == [2.0, 1.2]
    assert found.distance[1, 2] == 2.0


def test_meetings_of_the_last_rule_count():
    scene = parse_scene(
        THREE + "pairs:\n  - {between: [all, sam], meet: {within: 2.0}}\n"
        "  - {between: [bob, sam], meet: {within: 1.0, window: [3, 8]}}\n"
    )
    found = scene_meetings(scene)
    assert [(one.first, one.second) for one in found] == [(0, 1), (0, 2)]
    assert [one.meet for one in found] == [Meet(2.0), Meet(1.0, (3.0, 8.0))]


def test_limits_and_visits_are_read():
    own = (
        "    max_speed: 1.5\n    waypoints: [[2, 0], {at: [4, 1], window: [3, 9], dwell: 2}]\n"
        "  - id: ann\n"
    )
    scene = parse_scene(edited("  - id: ann\n", own) + "defaults: {max_acceleration: 0.5}\n")
    sam, ann = scene.agents
    assert (sam.max_speed, sam.max_acceleration) == (1.5, 0.5)
    assert sam.waypoints == ((2.0, 0.0), (4.0, 1.0))
    assert sam.visits == (Visit(), Visit((3.0, 9.0), 2.0))
    assert (ann.max_speed, ann.max_acceleration, ann.visits) == (None, 0.5, ())


@pytest.mark.parametrize(
    ("own", "words"),
    [
        ("max_speed: 0", "agents[0].max_speed: is 0; more than 0"),
        ("max_acceleration: fast", "agents[0].max_acceleration: is 'fast'; a number"),
        ("waypoints: [[1, 0, 2]]", "agents[0].waypoints[0]: is a list of 3; a point [x, y] in m"),
        ("waypoints: [{dwell: 2}]", "agents[0].waypoints[0].at: is missing"),
        ("waypoints: [{at: [1, 0], dwel: 2}]", "agents[0].waypoints[0].dwel: unknown key; did you"),
        ("waypoints: [{at: [1, 0], window: 3}]", "is 3; an interval [from, to] in s is expected"),
        ("waypoints: [{at: [1, 0], window: [9, 3]}]", "waypoints[0].window: reaches from 9 s to 3"),
        ("waypoints: [{at: [1, 0], dwell: -1}]", "waypoints[0].dwell: is -1; at least 0"),
        (
            "waypoints: [{at: [1, 0], window: [3, 5], dwell: 4}]",
            "waypoints[0]: cannot be left before 7 s; no later than 5 s is expected",
        ),
        (
            "waypoints: [{at: [1, 0], dwell: 9}, {at: [2, 0], window: [1, 8]}]",
            "waypoints[1]: cannot be left before 9 s; no later than 8 s",
        ),
        ("waypoints: [{at: [1, 0], dwell: 21}]", "cannot be left before 21 s; no later than 20 s"),
    ],
)
def test_limits_and_visits_that_are_refused(own, words):
    (message,) = refusals(edited("  - id: ann\n", f"    {own}\n  - id: ann\n"))
    assert message.startswith("scene.yaml:9:")
    assert words in message


@pytest.mark.parametrize(
    ("top", "words"),
    [
        (
            "groups: [{members: [sam, an], grouping: 1}]",
            "groups[0].members: there is no agent 'an'",
        ),
        ("groups: [{members: [sam], grouping: 1}]", "groups[0].members: name fewer than two"),
        (
            "groups: [{members: [sam, ann]}]",
            "groups[0]: changes nothing; one of distance, grouping",
        ),
        ("groups: [{name: sam, members: [sam, ann]}]", "groups[0].name: is 'sam', which means"),
        ("groups: [{name: all, members: [sam, ann]}]", "groups[0].name: is 'all', which means"),
        ("pairs: [{between: [sam, ann], meet: {}}]", "pairs[0].meet.within: is missing"),
        ("pairs: [{between: [sam, ann], meet: {within: 0}}]", "meet.within: is 0; more than 0"),
        (
            "pairs: [{between: [sam, ann], meet: {within: 0.6}}]",
            "pairs[0].meet: 'sam' and 'ann' meet within 0.6 m, but keep more than 0.6 m apart",
        ),
        (
            "groups: [{members: [sam, ann], distance: 2, meet: {within: 1}}]",
            "groups[0].meet: 'sam' and 'ann' meet within 1 m, but keep more than 2 m apart",
        ),
        (
            "pairs: [{between: [sam, ann], meet: {within: 1, window: [25, 30]}}]",
            "pairs[0].meet: 'sam' and 'ann' are never both present in time for it",
        ),
        (
            "pairs: [{between: [sam, ann], meet: {within: 1, window: [5, 3]}}]",
            "pairs[0].meet.window: reaches from 5 s to 3 s",
        ),
    ],
)
def test_groups_and_meetings_that_are_refused(top, words):
    (message,) = refusals(PAIR + top)
    assert words in message


def test_pairs_that_pass_through_each_other_may_meet_closely():
    rule = "pairs: [{between: [sam, ann], collide: false, meet: {within: 0.1}}]"
    assert scene_meetings(parse_scene(PAIR + rule))[0].meet == Meet(0.1)


def test_agents_that_move_as_told_have_no_limits():
    told = "path: [[0, 0, 0], [10, 0, 9]]"
    scene = parse_scene(
        edited("    start: [0.0, 0.0]\n    goal: [10.0, 0.0]\n", f"    {told}\n")
        + "defaults: {max_speed: 0.1}\n"
    )
    assert [agent.max_speed for agent in scene.agents] == [None, 0.1]
    text = edited(
        "    start: [0.0, 0.0]\n    goal: [10.0, 0.0]\n", f"    {told}\n    max_speed: 1\n"
    )
    assert "agents[0].max_speed: belongs to agents that find their way" in refusals(text)[0]
