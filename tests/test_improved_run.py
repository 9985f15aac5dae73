"""A finished run improved by the command: written anew as a whole, or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stplan.cli.app import main
from stplan.files import details
from stplan.files.manifest import why_incomplete
from stplan.files.npz_file import read_arrays

SCENE = """\
stplan: 1
horizon: 12.0
solver: {knots: 16, starts: 1}
agents:
  - {id: sam, start: [-3.0, 0.0], goal: [3.0, 0.1], radius: 0.5}
  - {id: ann, start: [3.0, 0.0], goal: [-3.0, 0.0], radius: 0.5}
  - {id: eve, start: [0.0, -3.0], goal: [0.1, 3.0], radius: 0.5}
"""


def stplan(*arguments: object) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    return int(left.value.code or 0)


def report(folder: Path) -> dict:
    return json.loads((folder / "report.json").read_text())


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "run.json"}


@pytest.fixture
def finished(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "three.yaml").write_text(SCENE)
    assert stplan("solve", "three.yaml") == 0
    return tmp_path / "outputs/three"


def test_a_run_is_improved_in_place(finished, capsys):
    before = report(finished)
    seed = (finished / "seed.npz").read_bytes()
    assert stplan("improve", finished, "--budget", "6") == 0
    after = report(finished)
    improvement = after["improvement"]
    assert improvement["moves"] == 6
    assert improvement["cost_after"] <= improvement["cost_before"]
    assert after["certificate"]["holds"]
    assert after["seed"] == before["seed"]
    assert after["scene"] == before["scene"]
    assert (finished / "seed.npz").read_bytes() == seed
    assert why_incomplete(finished) == ""
    assert "of 6 moves" in capsys.readouterr().out
    assert stplan("check", finished) == 0


def test_solve_and_improve_give_the_same_as_improve_later(finished):
    assert stplan("improve", finished, "--budget", "4", "-q") == 0
    assert stplan("solve", "three.yaml", "-o", "other", "--improve", "4", "-q") == 0
    assert contents(Path("other/three")) == contents(finished)


@pytest.mark.parametrize("damage", ["file", "scene", "report", "budget"])
def test_what_cannot_be_improved_is_refused_and_left_alone(damage, finished, capsys):
    budget = "4"
    if damage == "file":
        (finished / "trajectories.csv").write_text("agent,knot,x,y,t\n")
    elif damage == "scene":
        Path("three.yaml").write_text(SCENE.replace("0.5", "0.4"))
    elif damage == "report":
        (finished / "report.json").unlink()
    else:
        budget = "soon"
    before = contents(finished)
    assert stplan("improve", finished, "--budget", budget) == 2
    assert contents(finished) == before
    assert capsys.readouterr().err


def test_details_of_many_agents_are_those_of_the_improved_plan(tmp_path, monkeypatch):
    monkeypatch.setattr(details, "MOST", 2)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "three.yaml").write_text(SCENE.replace("starts: 1", "outer_iterations: 2"))
    assert stplan("solve", "three.yaml") == 0
    folder = tmp_path / "outputs/three"
    before = read_arrays(folder / "details.npz")
    assert stplan("improve", folder, "--budget", "4") == 0
    after = read_arrays(folder / "details.npz")
    assert after.keys() == before.keys()
    assert why_incomplete(folder) == ""
    for table in (report(folder)[part]["agents"] for part in ("metrics", "bound")):
        assert set(table["arrays"]) <= after.keys()
    seeds = report(folder)["seed"]["metrics"]["agents"]["arrays"]
    assert all(after[name].tolist() == before[name].tolist() for name in seeds)
