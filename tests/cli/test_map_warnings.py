"""What there is to know about a map is said by every command that reads it, and kept in the report."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

TRIANGLE = "v -6 0 4\nv 6 0 4\nv 6 0 -4\nf 1 2 3\n"
SCENE = """\
stplan: 1
name: wedge
map: {mesh: wedge.obj, up: y}
horizon: 9.0
agents:
  - {id: sam, start: [5.0, -3.0], goal: [5.0, 1.0], radius: 0.25}
"""
HEAD = "warning: wedge.yaml:3:24: map.up: wedge.obj: "


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scene whose mesh earlier versions mirrored, in the working directory."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wedge.obj").write_text(TRIANGLE)
    (tmp_path / "wedge.yaml").write_text(SCENE)
    return tmp_path


def warnings(err: str) -> list[str]:
    return [line for line in err.splitlines() if line.startswith("warning: ")]


def test_every_command_says_it(folder: Path, run) -> None:
    for command in (["validate"], ["solve"], ["seed"], ["explain", "--time-limit", "0"]):
        result = run(*command, "wedge.yaml")
        assert result.status == 0
        (line,) = warnings(result.err)
        assert line.startswith(HEAD)
    result = run("check", "wedge.yaml", "outputs/wedge/trajectories.csv")
    assert (result.status, len(warnings(result.err))) == (0, 1)
    assert len(warnings(run("explain", "outputs/wedge").err)) == 1
    report = json.loads((folder / "outputs" / "wedge" / "report.json").read_text())
    (note,) = report["notes"]
    assert f"warning: wedge.yaml:3:24: {note}" == line


def test_quiet_is_quiet_and_json_holds_it(folder: Path, run) -> None:
    assert run("validate", "--quiet", "wedge.yaml").err == ""
    (record,) = run("validate", "--json", "wedge.yaml").json["scenes"]
    assert record["status"] == "valid"
    (warning,) = record["warnings"]
    assert warning.startswith(HEAD)
