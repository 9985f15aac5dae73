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


HALL = """\
stplan: 1
horizon: 40
map: {rectangle: [0, 0, 12, 8]}
places:
  hall: {rectangle: [0, 0, 4, 8]}
  west: {line: [[1, 1], [1, 7]]}
  east: {line: [[11, 1], [11, 7]]}
  spare: {circle: {center: [8, 4], radius: 1}}
agents:
  - {id: p, count: 2, start: {place: hall}, goal: {any: [west, east]}, after_arrival: vanish}
  - {id: q, source: {place: hall}, goal: {place: west}, rate: 1, during: [5, 7], after_arrival: vanish}
  - {id: r, start: [9, 1], goal: {place: east}, after_arrival: vanish}
  - {id: s, start: [9, 3], goal: {rectangle: [10, 6, 11, 7]}, after_arrival: vanish}
"""


def _mean(side: str) -> list[str]:
    """Whom a side means, by the ids of those it is drawn to."""
    scene = parse_scene(f"{HALL}pairs: [{{between: [{side}, all], grouping: 1}}]")
    return [scene.agents[a].id for a in scene.pairs[0].left]


@pytest.mark.parametrize(
    ("side", "meant"),
    [
        ("{start: hall}", ["p-1", "p-2", "q-1", "q-2"]),
        ("{goal: west}", ["p-1", "p-2", "q-1", "q-2"]),
        ("{goal: east}", ["p-1", "p-2", "r"]),
        ("{start: hall, goal: east}", ["p-1", "p-2"]),
    ],
)
def test_places_mean_who_starts_or_ends_there(side, meant):
    assert _mean(side) == meant


@pytest.mark.parametrize(
    ("side", "path", "text"),
    [
        ("{start: hull}", ".start", "is 'hull', which is none of the scene's places"),
        ("{goal: hall}", ".goal", "is 'hall', where no agent ends"),
        ("{start: spare}", ".start", "is 'spare', where no agent starts"),
        ("{start: hall, goal: spare}", ".goal", "is 'spare', where no agent ends"),
        ("{}", "", "has neither start nor goal"),
        ("{place: hall}", ".place", "unknown key"),
        ("{start: 3}", ".start", ""),
        ("[{start: hall}]", "", "a list of ids"),
    ],
)
def test_places_of_nobody_are_refused(side, path, text):
    message = refusal(f"{HALL}pairs:\n  - {{between: [r, {side}], distance: 0.9}}\n")
    assert message.startswith("scene.yaml:15:")
    assert f"pairs[0].between[1]{path}: " in message
    assert text in message


def test_places_of_two_crowds_may_mean_nobody_in_common():
    text = HALL.replace("goal: {place: east}", "goal: {place: spare}")
    text = text.replace("any: [west, east]", "any: [west]")
    assert "is no agent" in refusal(
        f"{text}pairs: [{{between: [{{start: hall, goal: spare}}, all], distance: 1}}]"
    )
