"""What a plan has to forgive, as a scene says it."""

from __future__ import annotations

import pytest

from stplan.errors import SceneError
from stplan.scene import parse_scene
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import Robust

TEXT = """\
stplan: 1
name: hall
horizon: 10
map: {rectangle: [0, 0, 10, 10]}
agents:
  - {id: ann, start: [1, 1], goal: [9, 1]}
  - {id: bob, start: [1, 5], goal: [9, 5], radius: 0.4}
  - {id: cem, start: [1, 8], goal: [9, 8]}
pairs: [{between: [ann, cem], distance: 1.0}]
"""


def test_errors_of_tracking_make_everybody_larger() -> None:
    plain, wider = parse_scene(TEXT), parse_scene(TEXT + "robust: {tracking: 0.05}\n")
    for one, other in zip(plain.agents, wider.agents, strict=True):
        assert other.radius == pytest.approx(one.radius + 0.05)
    more = scene_interactions(wider).distance - scene_interactions(plain).distance
    assert more == pytest.approx(0.1)
    assert wider.robust == Robust(0.0, 0.05)
    assert wider.content_hash != plain.content_hash


def test_a_delay_changes_nothing_but_what_is_asked() -> None:
    plain, late = parse_scene(TEXT), parse_scene(TEXT + "robust: {delay: 2}\n")
    assert late.robust == Robust(2.0, 0.0)
    assert late.agents == plain.agents
    assert late.content_hash != plain.content_hash


def test_nothing_asked_is_what_scenes_have_always_been() -> None:
    assert parse_scene(TEXT + "robust: {}\n").content_hash == parse_scene(TEXT).content_hash


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("robust: {delay: -1}", r"10:10: robust\.delay: is -1"),
        ("robust: {tracking: .inf}", r"10:10: robust\.tracking: is inf"),
        ("robust: 2", r"10:1: robust: is 2; a mapping"),
        ("robust: {delay: 1}\ndefaults: {perception: {radius: 3}, max_speed: 1}",
         r"robust\.delay: is for plans"),
        ("robust: {tracking: 2}", r"agents\[1\]\.start: is 4 m from the start of 'ann'"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_is_said(line: str, sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        parse_scene(TEXT + line + "\n")
