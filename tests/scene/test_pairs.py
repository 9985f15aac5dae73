"""Pairs: who collides, at which distance; who overlaps where nobody can give way."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.scene import parse_scene, scene_interactions
from tests.scene.samples import agents_text as _agents
from tests.scene.samples import refusal

CLOSE_STARTS = ("id: sam, start: [0, 0], goal: [5, 0]", "id: ann, start: [0.5, 0], goal: [5, 5]")
CLOSE_GOALS = ("id: sam, start: [0, 0], goal: [5, 0]", "id: ann, start: [0, 5], goal: [5, 0.5]")
OFF = [
    "pairs: [{between: [sam, ann], collide: false}]",
    "pairs: [{between: [ann, all], collide: false}]",
    "pairs: [{between: [all, sam], distance: 0.4}]",
    "defaults: {weights: {collision: 0}}",
    "defaults: {radius: 0.2}",
]


def test_overlapping_starts():
    message = refusal(_agents(*CLOSE_STARTS))
    assert message.startswith("scene.yaml:5:")
    assert "agents[1].start: is 0.5 m from the start of 'sam'" in message


def test_overlapping_goals():
    assert "agents[1].goal: " in refusal(_agents(*CLOSE_GOALS))


@pytest.mark.parametrize("top", OFF)
@pytest.mark.parametrize("agents", [CLOSE_STARTS, CLOSE_GOALS], ids=["starts", "goals"])
def test_only_who_collides_overlaps(agents, top):
    assert parse_scene(_agents(*agents, top=top))


def test_one_weight_switches_no_pair_off():
    assert refusal(_agents(CLOSE_GOALS[0] + ", weights: {collision: 0}", CLOSE_GOALS[1]))


def test_other_times_do_not_overlap():
    assert parse_scene(_agents(CLOSE_STARTS[0], CLOSE_STARTS[1] + ", start_time: 5"))
    assert parse_scene(_agents(CLOSE_GOALS[0] + ", after_arrival: vanish", CLOSE_GOALS[1]))


def test_a_wider_distance_overlaps():
    text = _agents(
        "id: sam, start: [0, 0], goal: [9, 0]",
        "id: ann, start: [0, 2], goal: [9, 9]",
        top="pairs: [{between: [sam, ann], distance: 2.5}]",
    )
    assert "more than 2.5 m" in refusal(text)


def _pairs(rules: str):
    ids = "abcd"
    agents = (f"id: {x}, start: [0, {9 * k}], goal: [9, {9 * k}]" for k, x in enumerate(ids))
    return scene_interactions(parse_scene(_agents(*agents, top=f"pairs: [{rules}]")))


def test_pairs_default():
    pairs = _pairs("")
    off = ~np.eye(4, dtype=bool)
    assert (pairs.collides == off).all()
    assert (pairs.distance[off] == 0.6).all()
    assert not pairs.grouping.any()


def test_pairs_of_lists_and_all():
    pairs = _pairs("{between: [[a, b], [c]], grouping: 2}, {between: [d, all], collide: false}")
    expected = np.zeros((4, 4))
    expected[:2, 2] = expected[2, :2] = 2
    assert (pairs.grouping == expected).all()
    assert not pairs.collides[3].any()
    assert not pairs.collides[:, 3].any()
    assert pairs.collides[0, 1]
    # Who stands on both sides is no pair with itself.
    assert not np.diag(_pairs("{between: [all, all], grouping: 1}").grouping).any()


def test_later_pairs_win():
    pairs = _pairs(
        "{between: [all, all], distance: 1, collide: false}, {between: [b, a], distance: 2}, "
        "{between: [a, [b, c]], collide: true}"
    )
    assert pairs.distance[0, 1] == pairs.distance[1, 0] == 2
    assert pairs.distance[0, 2] == 1
    assert pairs.collides[0, 1]
    assert pairs.collides[2, 0]
    assert not pairs.collides[1, 2]
