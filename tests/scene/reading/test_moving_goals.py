"""Goals that move: what they mean, and what is wrong with them."""

from __future__ import annotations

import pytest

from stplan.scene import parse_scene
from tests.scene.samples import refusal

TEXT = """\
stplan: 1
name: chase
horizon: 20
map: {rectangle: [0, 0, 10, 10]}
places: {den: {circle: {center: [8, 8], radius: 1}}}
defaults: {radius: 0.3, max_speed: 1}
agents:
  - {id: fox, start: [1, 1], goal: {pursue: [hare, mouse]}}
  - {id: hare, start: [5, 5], goal: {evade: fox, places: [den]}}
  - {id: mouse, start: [7, 2], goal: [9, 1], radius: 0.1}
"""
FOX = "{pursue: [hare, mouse]}"


def test_what_goals_mean() -> None:
    fox, hare, mouse = parse_scene(TEXT).agents
    assert fox.moving_goal is not None
    assert (fox.moving_goal.kind, fox.moving_goal.others) == ("pursue", ("hare", "mouse"))
    assert fox.moving_goal.capture == pytest.approx(1.5 * 0.6)
    assert hare.moving_goal is not None
    assert [place.name for place in hare.moving_goal.places] == ["den"]
    assert hare.goal == hare.start
    assert mouse.moving_goal is None
    assert parse_scene(TEXT).replan_every == 0.5


def test_one_name_is_a_list_of_one() -> None:
    listed = parse_scene(TEXT.replace("evade: fox", "evade: [fox]"))
    assert listed.content_hash == parse_scene(TEXT).content_hash


def test_what_is_decided_how_often_is_part_of_the_meaning() -> None:
    assert parse_scene(TEXT + "replan_every: 1\n").content_hash != parse_scene(TEXT).content_hash


@pytest.mark.parametrize(
    ("old", "new", "place", "sentence"),
    [
        (FOX, "{pursue: [hare, mous]}", "8:37: agents[0].goal.pursue", "did you mean 'mouse'?"),
        (FOX, "{pursue: fox}", "8:37: agents[0].goal.pursue", "the agent itself"),
        (FOX, "{pursue: hare, evade: mouse}", "agents[0].goal", "has pursue and evade of"),
        (FOX, "{follow: hare}", "agents[0].goal.within", "is missing"),
        (FOX, "{follow: hare, within: 2, capture: 1}", "agents[0].goal.capture", "belongs to pursue"),
        (FOX, "{pursue: []}", "agents[0].goal.pursue", "an agent's id, or a list of ids"),
        (FOX, "{pursue: hare, capture: 0.6}", "agents[0].goal.capture", "more than the 0.6 m"),
        (FOX, "{pursue: hare, capture: 6}", "agents[0].goal.capture", "hare starts nearer"),
        ("goal: [9, 1]", "goal: [9, 1], perception: {radius: 0.3}", "agents[2].perception.radius", "0.4 m"),
        ("goal: [9, 1]", "goal: [9, 1], perception: {}", "agents[2].perception.radius", "is missing"),
        (FOX, "{persue: hare}", "agents[0].goal.persue", "unknown key"),
        ("places: [den]", "places: [dan]", "agents[1].goal.places[0]", "did you mean 'den'?"),
        (", max_speed: 1", "", "defaults.max_speed", "is missing"),
        ("map: {rectangle: [0, 0, 10, 10]}\n", "", "map", "is missing"),
        ("goal: [9, 1]", "goal: {place: den}", "agents[2].goal", "goals are points or move"),
        ("goal: [9, 1]", "goal: [9, 1], waypoints: [[8, 1]]", "agents[2].waypoints", "waypoints"),
        ("goal: [9, 1]", "path: [[7, 2, 0], [9, 1, 5]]", "agents[2].path", "nobody moves on a path"),
        ("goal: [9, 1]", "goal: [9, 1], start_time: 2", "agents[2].start_time", "the same time"),
        ("goal: [9, 1]", "goal: [9, 1], max_time: 9", "agents[2].max_time", "until the horizon"),
        ("goal: [9, 1]", "goal: [9, 1], after_arrival: vanish", "agents[2].after_arrival", "nobody vanishes"),
        ("name: chase", "replan_every: 20", "replan_every", "less than the horizon 20 s"),
        ("name: chase", "minimise: makespan", "minimise", "goes with `minimise: energy` alone"),
        ("name: chase", "pairs: [{between: [fox, hare], meet: {within: 2}}]", "pairs[0].meet", "together"),
        ("name: chase", "events: [{at: 3, remove: hare}]", "events", "do not go together"),
    ],
)  # fmt: skip
def test_fault(old: str, new: str, place: str, sentence: str) -> None:
    assert old in TEXT
    message = refusal(TEXT.replace(old, new, 1))
    assert f"{place}: " in message
    assert sentence in message


def test_how_often_has_no_meaning_where_nothing_moves() -> None:
    text = TEXT.replace(FOX, "[2, 2]").replace("{evade: fox, places: [den]}", "[6, 6]")
    assert "replan_every: belongs to goals that move" in refusal(text + "replan_every: 1\n")


def test_goals_do_not_begin_to_move_on_the_way() -> None:
    text = TEXT.replace(FOX, "[2, 2]").replace("{evade: fox, places: [den]}", "[6, 6]")
    event = "events: [{at: 3, set: {agents.fox.goal: {pursue: hare}}}]\n"
    assert "do not go together" in refusal(text + event)
