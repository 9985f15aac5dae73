"""Exit statuses, streams and files of every command, whatever planning does."""

from __future__ import annotations

import errno
import itertools
import json
import os
import re
from pathlib import Path

import pytest

from stplan.cli.console import worst
from stplan.errors import SeedingError
from stplan.files.json_file import json_bytes
from stplan.status import Status
from tests.cli.conftest import SCENE

FILES = ["report.json", "run.json", "seed.csv", "seed.npz", "trajectories.csv", "trajectories.npz"]

# Of bad.yaml, by their places.
FAULTS = [["bad.yaml:2:1:", "horizon:"], ["bad.yaml:4:52:", "agents[0].radios:"]]


def _names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def test_solve_writes_and_sums_up(stage, run):
    result = run("solve", "one.yaml")
    assert result.status == 0
    assert result.err == "outer iteration 1\n"
    assert result.out.splitlines() == [
        "one: converged",
        f"  {stage.example.certificate.summary}",
        f"  kinetic cost {stage.example.report.metrics.kinetic_over_straight:.4f} times "
        "the straight lines', latest arrival 5.00 s",
        "  cost 3.2, at most 1.7e-06 % above any plan's",
        "  outputs/one/: seed.csv seed.npz trajectories.csv trajectories.npz report.json run.json",
    ]
    assert _names("outputs/one") == FILES


def test_verbose_and_quiet(stage, run):
    result = run("solve", "one.yaml", "--verbose")
    assert result.err.startswith("[")
    assert result.err.endswith(" s] outer iteration 1\n")
    assert "  sam: arrives 5.00 s, path 4.00 m, fastest 0.80 m/s" in result.out
    assert re.search(r"seed \d+\.\d\d s, .*total \d+\.\d\d s", result.out)
    result = run("solve", "one.yaml", "-q")
    assert (result.status, result.out, result.err) == (0, "", "")
    result = run("solve", "one.yaml", "-q", "-v")
    assert result.status == 2
    assert result.err == "--quiet and --verbose exclude each other\n"


def test_solve_json_is_one_object(stage, run):
    result = run("solve", "one.yaml", "two.yaml", "-o", "there", "--json", "--set", "horizon=9")
    assert result.json["exit_status"] == 0
    first, second = result.json["scenes"]
    assert first["name"] == "one"
    assert first["folder"] == "there/one"
    assert "there/one/trajectories.csv" in first["files"]
    assert second["report"]["metrics"] == json.loads(
        json_bytes(stage.example.report.metrics.as_dict())
    )
    assert result.err == "one: outer iteration 1\ntwo: outer iteration 1\n"
    assert stage.overrides == [("horizon=9",)] * 2
    report = json.loads(Path("there/one/report.json").read_text())
    assert report["scene"]["overrides"] == ["horizon=9"]


def test_seed_writes_the_seed_only(stage, run):
    assert run("solve", "one.yaml").status == 0
    before = Path("outputs/one/report.json").read_bytes()
    assert run("seed", "one.yaml").status == 0
    assert Path("outputs/one/report.json").read_bytes() == before
    assert run("seed", "two.yaml").status == 0
    assert _names("outputs/two") == ["seed.csv", "seed.npz"]


def test_every_scene_is_planned_and_the_worst_status_counts(stage, run):
    stage.outcomes["one"] = Status.FAILED
    stage.raises["two"] = SeedingError("sam is blocked by ann")
    result = run("solve", "bad.yaml", "one.yaml", "two.yaml", "three.yaml", "--json")
    assert result.status == 2
    assert stage.planned == ["one", "two", "three"]
    assert [record["exit_status"] for record in result.json["scenes"]] == [2, 4, 3, 0]
    faults = result.json["scenes"][0]["messages"]
    assert [fault.split(" ")[:2] for fault in faults] == FAULTS
    assert result.err.splitlines() == [
        *faults,
        "more on this: docs/scene-format.md#top-level",
        "one: outer iteration 1",
        f"one: {Status.FAILED.advice}",
        "two: outer iteration 1",
        "two: sam is blocked by ann",
        f"two: more on this: {SeedingError.page}",
        "three: outer iteration 1",
    ]
    assert _names("outputs") == ["one", "three"]
    assert run("solve", "one.yaml", "two.yaml").status == 3
    assert run("solve", "one.yaml", "three.yaml").status == 4


def test_the_order_of_exit_statuses():
    order = [5, 130, 2, 3, 4, 1, 0]
    for better, poorer in itertools.combinations(reversed(order), 2):
        assert worst([better, poorer]) == worst([poorer, better]) == poorer
    assert worst([]) == 0


def test_two_scenes_of_one_name(stage, run):
    Path("other").mkdir()
    Path("other/one.yaml").write_text(SCENE)
    result = run("solve", "one.yaml", "other/one.yaml")
    assert result.status == 2
    assert "other/one.yaml and one.yaml are both named one" in result.err
    assert stage.planned == ["one"]


def test_a_limit_is_success_with_advice(stage, run):
    stage.outcomes["one"] = Status.LIMIT
    result = run("solve", "one.yaml")
    assert result.status == 0
    assert "raise solver.max_iterations to go on\n" in result.err
    assert run("solve", "one.yaml", "--quiet").err == ""


def test_interrupted_with_a_result(stage, run):
    stage.outcomes["one"] = Status.INTERRUPTED
    result = run("solve", "one.yaml", "two.yaml", "--json")
    assert result.status == 130
    assert "one: interrupted: these are the best feasible trajectories so far" in result.err
    assert stage.planned == ["one"]
    assert _names("outputs/one") == FILES
    assert result.json["scenes"][1]["status"] == "not planned"


def test_interrupted_without_a_result(stage, run):
    stage.raises["one"] = KeyboardInterrupt()
    result = run("solve", "one.yaml", "two.yaml")
    assert result.status == 130
    assert result.err.endswith("interrupted before there was a result; nothing was written\n")
    assert not Path("outputs").exists()
    assert stage.planned == ["one"]


def test_a_bug_is_one_line_and_a_file(stage, run, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    stage.raises["one"] = ZeroDivisionError("two\nlines")
    result = run("solve", "one.yaml", "--quiet", "--json")
    assert result.status == 5
    (line,) = result.err.splitlines()
    head, path = line.split("; traceback saved to ")
    assert head == "internal error: ZeroDivisionError: two lines"
    assert "Traceback (most recent call last)" in Path(path).read_text()
    assert result.json["scenes"][0]["messages"] == [line]


def test_a_bug_anywhere_else(stage, run, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    assert run("seed", "one.yaml").status == 0

    def broken(*arguments):
        raise RuntimeError("bug")

    monkeypatch.setattr("stplan.files.trajectories.read_trajectories", broken)
    result = run("check", "one.yaml", "outputs/one/seed.csv", "--json")
    assert result.status == 5
    assert result.err.startswith("internal error: RuntimeError: bug; the traceback could not be")
    assert result.json == {"exit_status": 5, "messages": result.err.splitlines()}


@pytest.mark.parametrize("command", ["solve", "seed", "validate"])
def test_wrong_paths(stage, run, command):
    result = run(command, "none.yaml", ".")
    assert result.status == 2
    assert result.err.splitlines() == [
        "cannot read none.yaml: no such file",
        ". is a folder; expected a scene file",
    ]
    assert result.out == ""


def test_output_that_cannot_be_written(stage, run):
    result = run("solve", "one.yaml", "-o", "one.yaml")
    assert result.status == 2
    assert result.err.splitlines()[-1].startswith("cannot write into one.yaml/one")


def test_a_full_disk(stage, run, monkeypatch):
    def full(path, content):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("stplan.files.atomic._write_flushed", full)
    result = run("solve", "one.yaml")
    assert result.status == 2
    assert "cannot write into outputs/one: No space left on device" in result.err
    assert not Path("outputs").exists()


def test_check_a_run(stage, run):
    assert run("solve", "one.yaml", "--set", "horizon=9").status == 0
    result = run("check", "outputs/one", "--set", "solver.mu=1")
    assert (result.status, result.out) == (
        0,
        "one: certificate holds; tightest sam and ann: 8.5 m at t = 0 s, (0, 4.5)\n",
    )
    assert stage.overrides[-1] == ("horizon=9", "solver.mu=1")
    elsewhere = ("--set", "agents.ann.goal=[4.0, 8.0]")
    result = run("check", "outputs/one", *elsewhere)
    assert result.status == 1
    verdict, *violations = result.out.splitlines()
    assert verdict.startswith("one: certificate IS BROKEN (1 violation)")
    assert violations[0].startswith("ann: ")
    result = run("check", "outputs/one", "outputs/one/seed.csv", "--json", *elsewhere)
    assert result.status == 1
    assert result.json["exit_status"] == 1
    assert result.json["holds"] is False
    assert result.json["violations"] == violations
    # What is set makes another scene, and so does what is written.
    assert result.json["scene_changed"] is True
    assert run("check", "outputs/one", "--json").json["scene_changed"] is False
    Path("one.yaml").write_text(Path("one.yaml").read_text().replace("0.25}", "0.2}"))
    result = run("check", "outputs/one")
    assert result.err == "note: one.yaml is not as it was when this run was planned\n"


def test_check_a_scene(stage, run):
    run("seed", "one.yaml")
    assert run("check", "one.yaml", "outputs/one/seed.npz").status == 0
    result = run("check", "one.yaml")
    assert result.status == 2
    assert "name the trajectories too: stplan check one.yaml TRAJECTORIES" in result.err
    assert run("check", "none", "outputs/one/seed.npz").err == "cannot read none: no such file\n"
    assert run("check", "one.yaml", "none.csv").err == "cannot read none.csv: no such file\n"
    result = run("check", "outputs/one")
    assert result.status == 2
    assert "holds no report.json" in result.err


def test_diff(stage, run):
    run("solve", "one.yaml")
    result = run("diff", "outputs/one", "outputs/one/trajectories.csv")
    assert (result.status, result.out) == (0, "equal: 2 agents\n")
    assert "sam: position 0 m" in run("diff", "outputs/one", "outputs/one", "-v").out
    text = Path("outputs/one/trajectories.csv").read_text()
    Path("moved.csv").write_text(text.replace("sam,1,2.0", "sam,1,2.5"))
    result = run("diff", "outputs/one", "moved.csv")
    assert result.status == 1
    assert result.out.startswith("sam: position 0.5 m at knot 1 (t = 2.5 s)")
    assert run("diff", "outputs/one", "moved.csv", "--atol", 0.6).status == 0
    result = run("diff", "outputs/one", "moved.csv", "--json")
    assert (result.status, result.json["exit_status"], result.json["equal"]) == (1, 1, False)
    for value in ("nan", "inf", "-1"):
        result = run("diff", "outputs/one", "moved.csv", "--rtol", value)
        assert result.status == 2
        assert "--rtol is" in result.err
    assert run("diff", "outputs/one", "none.csv").status == 2


def test_diff_of_folders_in_every_format(stage, run):
    for output in ("old", "new"):
        assert run("seed", "one.yaml", "two.yaml", "-o", output).status == 0
        for name in ("one", "two"):
            Path(output, name, "seed.csv").rename(Path(output, name, "trajectories.csv"))
    assert run("diff", "old", "new").out == "2 of 2 common runs equal\n"
    assert "one: sam: position 0 m" in run("diff", "old", "new", "--verbose").out
    moved = Path("new/two/trajectories.csv")
    moved.write_text(moved.read_text().replace("sam,1,2.0", "sam,1,2.5"))
    result = run("diff", "old", "new")
    assert (result.status, result.out.splitlines()[0]) == (1, "two:")
    result = run("diff", "old", "new", "--format", "markdown")
    assert result.status == 1
    assert result.out.startswith("### stplan diff: 1 of 2 common runs equal\n\n| run |")
    for options in (["--json"], ["--format", "json"], ["--json", "--format", "text"]):
        content = run("diff", "old", "new", *options).json
        assert [entry["equal"] for entry in content["runs"]] == [True, False]
    assert run("diff", "old", "new", "--format", "xml").status == 2


def test_validate(stage, run):
    walls = "map: {rectangle: [-1.0, -1.0, 5.0, 5.0]}\n"
    Path("two.yaml").write_text(SCENE.replace("agents:", f"{walls}agents:"))
    result = run("validate", "one.yaml", "two.yaml", "bad.yaml", "--json")
    assert result.status == 2
    assert [record["status"] for record in result.json["scenes"]] == ["valid", "error", "error"]
    lines = result.err.splitlines()
    pages = [line for line in lines if line.startswith("more on this: ")]
    assert [line.split(" ")[:2] for line in lines if line not in pages] == [
        ["two.yaml:6:15:", "agents[1].start:"], ["two.yaml:6:34:", "agents[1].goal:"], *FAULTS,
    ]  # fmt: skip
    assert (lines[2], lines[-1]) == tuple(pages)
    assert pages == [
        f"more on this: docs/scene-format.md#{section}" for section in ("agents", "top-level")
    ]
    assert run("validate", "two.yaml", "--quiet").err.splitlines() == lines[:2]
    result = run("validate", "one.yaml")
    assert (result.status, result.out) == (0, "one.yaml: valid, one with 2 agents\n")


def test_schema(run, monkeypatch):
    monkeypatch.setattr("stplan.scene.scene_schema", lambda: {"type": "object"})
    result = run("schema")
    assert (result.status, result.json) == (0, {"type": "object"})


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["none"],
        ["solve"],
        ["solve", "--bogus"],
        ["diff", "a"],
        ["diff", "a", "b", "--atol", "x"],
    ],
)
def test_a_wrong_command_line(run, arguments):
    result = run(*arguments)
    assert result.status == 2
    assert "Usage: stplan" in result.err + result.out


def test_help_names_every_exit_status_and_shows_examples(run):
    result = run("--help")
    assert result.status == 0
    for status in (0, 1, 2, 3, 4, 5, 130):
        assert f"\n    {status:<5}" in result.out
    for command in ("solve", "seed", "check", "diff", "validate", "schema"):
        assert f"    stplan {command} " in run(command, "--help").out
