"""The garbage collector rests while scenes are read, and goes on afterwards as it was."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest

from stplan.scene import load_scene
from stplan.scene.reading import load
from stplan.schema.collector import collector_paused

SCENE = "stplan: 1\nhorizon: 5\nagents: [{id: a, start: [0, 0], goal: [1, 1]}]\n"


def test_it_rests_while_a_scene_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.yaml").write_text(SCENE)
    seen = []
    read_tree = load.read_tree
    monkeypatch.setattr(
        load, "read_tree", lambda *args: seen.append(gc.isenabled()) or read_tree(*args)
    )
    assert gc.isenabled()
    load_scene(tmp_path / "a.yaml")
    assert seen == [False]
    assert gc.isenabled()


def test_it_is_left_as_it_was_whatever_happens() -> None:
    with pytest.raises(ZeroDivisionError), collector_paused():
        raise ZeroDivisionError
    assert gc.isenabled()
    gc.disable()
    try:
        with collector_paused():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()
