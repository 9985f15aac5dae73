"""A run's folder leads back to its scene."""

from __future__ import annotations

import pytest

from stplan.errors import UsageError
from stplan.files.json_file import json_bytes
from stplan.files.run_folder import recorded_scene


def _report(folder, scene):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "report.json").write_bytes(json_bytes({"scene": scene}))
    return folder


def test_absolute_and_relative_sources(tmp_path, monkeypatch):
    source = tmp_path / "scenes" / "s.yaml"
    source.parent.mkdir()
    source.write_text("")
    run = tmp_path / "outputs" / "s"
    recorded = recorded_scene(_report(run, {"source": str(source), "hash": "ab"}))
    assert (recorded.source, recorded.overrides, recorded.content_hash) == (source, (), "ab")
    _report(run, {"source": "scenes/s.yaml", "overrides": ["horizon=3"]})
    monkeypatch.chdir(run)
    recorded = recorded_scene(run)
    assert recorded.source.samefile(source)
    assert recorded.overrides == ("horizon=3",)
    assert recorded.content_hash is None
    monkeypatch.chdir(tmp_path)
    assert str(recorded_scene(run).source) == "scenes/s.yaml"


def test_says_what_is_missing(tmp_path):
    with pytest.raises(UsageError, match=r"holds no report\.json"):
        recorded_scene(tmp_path)
    for scene in (None, {"name": "s"}, {"source": None}):
        with pytest.raises(UsageError, match="names no scene file"):
            recorded_scene(_report(tmp_path, scene))
    with pytest.raises(UsageError, match=r"its scene file gone\.yaml is missing"):
        recorded_scene(_report(tmp_path, {"source": "gone.yaml"}))
    with pytest.raises(UsageError, match="expected a list of KEY=VALUE"):
        recorded_scene(_report(tmp_path, {"source": "s", "overrides": 3}))
