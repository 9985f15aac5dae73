"""The real thing on two agents in the open plane, from the file to the certificate."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stplan.planner import plan, write_plan
from stplan.scene import load_scene

SCENE = """\
stplan: 1
name: crossing
horizon: 6.0
agents:
  - {id: sam, start: [-2.0, 0.0], goal: [2.0, 0.1], radius: 0.3, mass: 70.0}
  - {id: ann, start: [0.1, -2.0], goal: [0.0, 2.0], radius: 0.3, mass: 50.0}
"""


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = Path("crossing.yaml")
    path.write_text(SCENE)
    return path


def test_solve_check_diff(scene, run):
    result = run("solve", scene, "--json")
    assert result.status == 0, result.err
    (record,) = result.json["scenes"]
    assert record["report"]["certificate"]["holds"]
    folder = Path("outputs/crossing")
    assert {path.name for path in folder.iterdir()} == {
        "trajectories.csv", "trajectories.npz", "seed.csv", "seed.npz", "report.json", "run.json",
    }  # fmt: skip
    assert run("check", folder).status == 0
    assert run("check", scene, folder / "trajectories.csv").status == 0
    assert run("check", scene, folder / "seed.csv").status == 0
    assert run("diff", folder, folder / "trajectories.csv", "--atol", 0).status == 0
    assert run("diff", folder, folder / "seed.csv").status == 1

    # The same scene again: the same bytes, run.json excepted.
    assert run("solve", scene, "-o", "again", "-q").status == 0
    for name in ("trajectories.csv", "trajectories.npz", "seed.csv", "seed.npz", "report.json"):
        assert (folder / name).read_bytes() == (Path("again/crossing") / name).read_bytes()


def test_explain(scene, run):
    assert run("explain", scene, "--time-limit", 0).out.startswith("crossing: a valid scene.\n")
    assert run("solve", scene, "-q").status == 0
    result = run("explain", "outputs/crossing")
    assert result.status == 0
    assert result.out.startswith("crossing: planning ended as 'converged'; the certificate holds.")
    sections = run("explain", "outputs/crossing", "--json").json["sections"]
    assert list(sections) == ["pairs", "walls", "waits", "late", "detours", "costs"]
    Path("straight.csv").write_text(
        "agent,knot,x,y,t\nsam,0,-2,0,0\nsam,1,2,0.1,6\nann,0,0.1,-2,0\nann,1,0,2,6\n"
    )
    result = run("explain", scene, "straight.csv")
    assert result.status == 1
    assert "sam and ann: " in result.out
    result = run("explain", "outputs/crossing", "--set", "agents.ann.start=[0, -1.5]")
    assert result.status == 1
    assert "is not as it was when this run was planned" in result.err


def test_explain_what_cannot_be_planned(scene, run):
    walls = "map: {rectangle: [-3, -3, 3, 3], obstacles: [{rectangle: [-1, -3, -0.9, 3]}]}\n"
    scene.write_text(SCENE.replace("agents:", f"{walls}agents:"))
    result = run("explain", scene)
    assert result.status == 3
    assert "sam: its start and goal lie in separate parts of the map" in result.out
    assert run("explain", scene, "--time-limit", "nan").status == 2
    scene.write_text(
        SCENE.replace("[2.0, 0.1]", "[2.9, 0.1]").replace("agents:", f"{walls}agents:")
    )
    result = run("explain", scene)
    assert result.status == 2
    assert "crossing.yaml:6:" in result.err


def test_check_finds_a_collision(scene, run):
    Path("straight.csv").write_text(
        "agent,knot,x,y,t\nsam,0,-2,0,0\nsam,1,2,0.1,6\nann,0,0.1,-2,0\nann,1,0,2,6\n"
    )
    result = run("check", scene, "straight.csv")
    assert result.status == 1
    assert "sam and ann" in result.out
    assert run("check", scene, "straight.csv", "--json").json["holds"] is False


def test_check_finds_time_running_back(scene, run):
    Path("back.csv").write_text(
        "agent,knot,x,y,t\nsam,0,-2,0,0\nsam,1,0,0,7\nsam,2,2,0.1,6\nann,0,0.1,-2,0\nann,1,0,2,6\n"
    )
    assert run("check", scene, "back.csv").status == 1


def test_check_of_other_agents(scene, run):
    Path("other.csv").write_text("agent,knot,x,y,t\nbob,0,-2,0,0\nbob,1,2,0.1,6\n")
    result = run("check", scene, "other.csv")
    assert result.status == 1
    assert "sam" in result.out


def test_overrides_are_remembered_by_the_run(scene, run):
    assert run("solve", scene, "--set", "horizon=9.0", "-q").status == 0
    report = json.loads(Path("outputs/crossing/report.json").read_text())
    assert report["scene"]["overrides"] == ["horizon=9.0"]
    result = run("check", "outputs/crossing")
    assert (result.status, result.err) == (0, "")
    assert run("validate", scene, "--set", "horizon=-1").status == 2


def test_a_plan_written_from_python_is_of_the_same_scene(scene, run):
    loaded = load_scene(scene, overrides=["horizon=9.0", "agents.sam.mass=60"])
    write_plan(plan(loaded), Path("mine"))
    assert json.loads(Path("mine/report.json").read_text())["scene"]["overrides"] == [
        "horizon=9.0", "agents.sam.mass=60",
    ]  # fmt: skip
    result = run("check", "mine")
    assert (result.status, result.err) == (0, "")
    settings = ("--set", "horizon=9.0", "--set", "agents.sam.mass=60")
    assert run("solve", scene, *settings, "-q").status == 0
    assert (
        Path("outputs/crossing/report.json").read_bytes() == Path("mine/report.json").read_bytes()
    )


def test_seed(scene, run):
    assert run("seed", scene).status == 0
    assert {path.name for path in Path("outputs/crossing").iterdir()} == {"seed.csv", "seed.npz"}


def test_faults_are_named_with_their_place(scene, run):
    scene.write_text(SCENE.replace("radius: 0.3", "radios: 0.3", 1).replace("6.0", "six"))
    for command in ("solve", "validate"):
        result = run(command, scene)
        assert result.status == 2
        assert "crossing.yaml:3:" in result.err
        assert "crossing.yaml:5:" in result.err
        assert "did you mean" in result.err
    assert not Path("outputs").exists()


def test_agents_that_overlap_at_their_starts(scene, run):
    scene.write_text(SCENE.replace("[0.1, -2.0]", "[-2.0, 0.1]"))
    result = run("validate", scene)
    assert result.status == 2
    assert "crossing.yaml:6:" in result.err
    assert "'sam'" in result.err
    assert run("solve", scene).status == 2


def test_schema(run):
    result = run("schema")
    assert result.status == 0
    assert "agents" in result.json["properties"]


def test_a_file_that_is_no_scene(scene, run):
    for text in ("", "[", "- a", "\x00"):
        scene.write_text(text)
        result = run("validate", scene)
        assert result.status == 2, text
        assert result.err.startswith("crossing.yaml"), text


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_while_optimising_the_best_so_far_is_written(scene, run, number):
    endless = ["--set", "solver.outer_iterations=1000", "--set", "solver.mu_decay=0.999"]
    with subprocess.Popen(
        [sys.executable, "-m", "stplan", "solve", str(scene), *endless],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith("outer 1/"):
                break
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted: these are the best feasible trajectories so far" in err
    report = json.loads(Path("outputs/crossing/report.json").read_text())
    assert report["status"] == "interrupted"
    assert run("check", "outputs/crossing").status == 0
