"""The hook for pre-commit: what it runs tells good scenes from bad ones, and says so only of the bad."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
SCENE = "stplan: 1\nhorizon: 9\nagents: [{id: sam, start: [0, 0], goal: [4, 0]}]\n"


def test_it_validates_the_scenes_that_it_is_given(run, tmp_path):
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))
    program, *words = shlex.split(hook["entry"])
    assert program == "stplan"
    (tmp_path / "good.yaml").write_text(SCENE)
    (tmp_path / "bad.yaml").write_text(SCENE.replace("goal", "gaol"))
    good = run(*words, tmp_path / "good.yaml")
    assert (good.status, good.out, good.err) == (0, "", "")
    bad = run(*words, tmp_path / "good.yaml", tmp_path / "bad.yaml")
    assert bad.status == 2
    assert "goal" in bad.err
    assert re.search(hook["files"], "scenes/bottleneck/bottleneck.yaml")


def test_the_documentation_names_it():
    page = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
    assert "- id: stplan-validate" in page
