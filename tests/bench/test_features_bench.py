"""Features of planners: what is judged, and what the planners that are installed show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stplan.bench import features, features_table
from stplan.bench.rivals.task import Motion

DOCS = Path(__file__).parents[2] / "docs"
FEATURES = {feature.name: feature for feature in features.FEATURES}


def _quiet(line: str) -> None:
    del line


def _straight(scene, seconds):
    ends = ((agent.start, agent.goal) for agent in scene.agents)
    curves = [np.array([[*a, 0.0], [*b, seconds]], dtype=np.float64) for a, b in ends]
    return Motion(curves, np.ones(len(curves), dtype=bool))


@pytest.mark.parametrize("name", FEATURES)
def test_this_planner_has_every_feature(name, monkeypatch):
    monkeypatch.setattr(features, "RIVALS", ())
    (one,) = features.measure([FEATURES[name]], progress=_quiet)
    assert one.there, one
    assert one.clearance > 0


@pytest.mark.parametrize("name", FEATURES)
def test_no_feature_is_there_when_everybody_goes_straight_ahead(name):
    scene = FEATURES[name].scene()
    one = features.judged(FEATURES[name], scene, "nobody", _straight(scene, 12.0))
    assert not one.there


def test_who_does_not_arrive_has_no_feature():
    feature = FEATURES["meeting on the way"]
    scene = feature.scene()
    motion = _straight(scene, 12.0)
    motion.curves[1][:, :2] = motion.curves[0][:, :2] + [0.0, 1.0]
    assert features.judged(feature, scene, "near", motion).there
    stuck = Motion(motion.curves, np.array([True, False]))
    one = features.judged(feature, scene, "near", stuck)
    assert (one.there, one.note) == (False, "1 of 2 arrive")


def test_rivals_are_told_when_to_arrive_but_not_whom_to_meet():
    chosen = [FEATURES["arrival when asked for"], FEATURES["meeting on the way"]]
    found = features.measure(chosen, progress=_quiet)
    shown = {(one.feature, one.planner): one.there for one in found}
    assert shown["arrival when asked for", "RVO2"]
    assert not shown["meeting on the way", "RVO2"]
    page = features_table.files(found)["features.md"].decode()
    assert "| meeting on the way" in page
    assert "| touching nothing" in page


def test_the_page_is_what_the_command_writes():
    page = (DOCS / "features.md").read_text(encoding="utf-8")
    assert page.startswith(features_table.INTRODUCTION)
    rows = [line.split("|")[1].strip() for line in page.splitlines() if line.startswith("| ")]
    assert rows[2:-1] == list(FEATURES)
