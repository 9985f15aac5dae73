"""A preset changes what a scene leaves out, and nothing else."""

from __future__ import annotations

import dataclasses
import math

import pytest

from stplan.errors import SceneError
from stplan.scene import parse_scene
from stplan.scene.presets import PAPER
from tests.scene.samples import scene_text


def test_what_is_left_out_is_as_the_paper_has_it() -> None:
    plain, paper = parse_scene(scene_text()), parse_scene(scene_text(top="preset: paper"))
    changed = {
        (part, name)
        for part in ("seeding", "solver")
        for name in dataclasses.asdict(getattr(plain, part))
        if getattr(getattr(plain, part), name) != getattr(getattr(paper, part), name)
    }
    assert changed == {("seeding", name) for name in PAPER.seeding} | {
        ("solver", name) for name in PAPER.solver
    }
    assert paper.solver.barrier_range == math.inf
    assert paper.solver.mu_decay == 0.75
    assert paper.agents == plain.agents


def test_what_the_scene_says_wins() -> None:
    said = "preset: paper\ntime_scale: 3\nseeding: {method: auto}\nsolver: {barrier_range: auto, knots: 40}"
    scene = parse_scene(scene_text(top=said))
    assert scene.time_scale == 3.0
    assert (scene.seeding.method, scene.seeding.shortcuts) == ("auto", False)
    assert (scene.solver.barrier_range, scene.solver.knots) == (None, 40)
    assert scene.solver.clearance_model == "smooth-minimum"


def test_a_preset_is_its_settings() -> None:
    """Two scenes that mean the same have the same hash, however they say it."""
    spelt = "{" + ", ".join(f"{key}: {_yaml(value)}" for key, value in PAPER.solver.items()) + "}"
    long = f"seeding: {{method: dijkstra, shortcuts: false}}\nsolver: {spelt}\ntime_scale: 1"
    short = parse_scene(scene_text(), overrides=("preset=paper",))
    assert short.content_hash == parse_scene(scene_text(top=long)).content_hash
    assert short.content_hash != parse_scene(scene_text()).content_hash


def _yaml(value: object) -> str:
    return ".inf" if value == math.inf else str(value).lower()


def test_an_unknown_preset_is_refused() -> None:
    with pytest.raises(SceneError, match="preset"):
        parse_scene(scene_text(top="preset: papers"))
