"""Scenes in which arrivals are to be early: what they need, and their horizon."""

from __future__ import annotations

import pytest

from stplan.errors import SceneError
from stplan.scene import parse_scene
from stplan.scene.horizon import with_chosen_horizon

SCENE = """\
stplan: 1
minimise: {minimise}
horizon: {horizon}
defaults: {{{defaults}}}
agents:
  - {{id: sam, start: [0, 0], goal: [6, 0]}}
  - {{id: ann, start: [0, 2], goal: [6, 2], start_time: 3{ann}}}
"""


def scene_text(minimise="makespan", horizon="auto", defaults="max_speed: 2", ann=""):
    return SCENE.format(minimise=minimise, horizon=horizon, defaults=defaults, ann=ann)


def refusal(**keys) -> str:
    with pytest.raises(SceneError) as refused:
        parse_scene(scene_text(**keys))
    (message,) = refused.value.messages
    return message


def test_energy_with_a_horizon_is_what_scenes_have_always_been():
    plain = scene_text(minimise="energy", horizon=20)
    without = plain.replace("minimise: energy\n", "")
    assert parse_scene(plain).content_hash == parse_scene(without).content_hash
    assert parse_scene(without).minimise == "energy"
    assert parse_scene(without).horizon_rule == "stated"


def test_an_open_horizon_leaves_everybody_time():
    scene = parse_scene(scene_text(ann=", max_time: 12"))
    assert scene.horizon_rule == "auto"
    sam, ann = scene.agents
    assert sam.max_time == scene.horizon > 3.0 + 6.0 / 2.0
    assert ann.max_time == 12.0
    chosen = with_chosen_horizon(scene, 7.5)
    assert (chosen.horizon, chosen.horizon_rule) == (7.5, "chosen")
    assert [agent.max_time for agent in chosen.agents] == [7.5, 12.0]


def test_speeds_are_needed():
    everybody = refusal(defaults="radius: 0.2")
    assert "defaults" in everybody
    assert "with `minimise: makespan` a speed in m/s is expected" in everybody
    one = refusal(defaults="", ann=", max_speed: 1.0", minimise="arrivals")
    assert "agents[0].max_speed: is missing; with `minimise: arrivals`" in one
    path = scene_text(defaults="", ann=", max_speed: 1").replace(
        "start: [0, 0], goal: [6, 0]", "path: [[0, 0, 0], [6, 0, 9]]"
    )
    assert parse_scene(path).minimise == "makespan"


def test_an_open_horizon_needs_a_reason():
    assert "horizon: is auto; a time in s is expected, or `minimise: arrivals`" in refusal(
        minimise="energy"
    )
    assert "a number or auto" in refusal(horizon="soon")
    assert "energy" in refusal(minimise="speed")
