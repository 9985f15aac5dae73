"""A batch as a whole: outputs, summaries, resuming, exit statuses."""

from __future__ import annotations

import csv
import hashlib
import json
from xml.etree import ElementTree

import pytest

from tests.batch.conftest import ENDLESS, RUN_FILES, lasting, stplan

ALL = ["one", "room", "three", "two"]


def _batch(place, *arguments):
    return stplan("batch", "scenes", "-o", "results", *arguments, cwd=place)


def test_all_runs_are_planned_and_summed_up(golden):
    folder = golden.place / "results"
    for name in ALL:
        assert {path.name for path in (folder / name).iterdir()} == RUN_FILES
    rows = list(csv.DictReader((folder / "batch.csv").read_text().splitlines()))
    assert [row["run"] for row in rows] == ALL
    for row in rows:
        assert row["state"] == "certified"
        assert row["certificate_holds"] == "true"
        assert float(row["smallest_clearance"]) > 0
        assert float(row["cost_kinetic"]) > 0
        assert float(row["seconds_total"]) > 0
    entry = json.loads((folder / "batch.json").read_text())["runs"][0]
    report = json.loads((folder / "one/report.json").read_text())
    assert entry["hash"] == report["scene"]["hash"]
    assert entry["costs"] == report["costs"]


def test_solve_writes_the_same_bytes_and_counts_as_done(golden, place):
    scenes = [f"scenes/{name}.yaml" for name in ALL]
    ended = stplan("solve", *scenes, "-o", "results", "-q", cwd=place)
    assert ended.status == 0, ended.err
    solved = lasting(place / "results")
    assert solved == {path: golden.contents[path] for path in solved}
    ended = _batch(place, "--dry-run")
    assert ended.out.split() == [word for name in ALL for word in ("done", name)]


def test_done_runs_are_skipped_and_changed_ones_planned_again(golden, place):
    results = golden.copy(place)
    before = {name: (results / name / "run.json").stat().st_mtime_ns for name in ALL}
    (place / "scenes/one.yaml").write_text(
        (place / "scenes/one.yaml").read_text().replace("70.0", "75.0")
    )
    (place / "scenes/room.obj").write_text(
        "# another mesh\n" + (place / "scenes/room.obj").read_text()
    )
    (results / "two/seed.csv").write_text("agent,knot,x,y,t\n")
    (place / "scenes/three.yaml").write_text(
        "# a comment changes nothing\n" + (place / "scenes/three.yaml").read_text()
    )
    preview = _batch(place, "--dry-run", "--json")
    assert {run["run"]: run["reason"] for run in preview.json["runs"]} == {
        "one": "the scene, its mesh or its settings have changed",
        "room": "the scene, its mesh or its settings have changed",
        "three": None,
        "two": "seed.csv is not the file that this run wrote",
    }
    assert {path.stat().st_mtime_ns for path in results.glob("*/run.json")} == set(before.values())

    ended = _batch(place, "--jobs", 1)
    assert ended.status == 0, ended.err
    after = {name: (results / name / "run.json").stat().st_mtime_ns for name in ALL}
    assert [name for name in ALL if after[name] != before[name]] == ["one", "room", "two"]
    assert "three: certified" in ended.err
    assert ended.err.count("done before") == 1
    assert lasting(results)["two/seed.csv"] == golden.contents["two/seed.csv"]


def test_another_version_and_force_plan_again(golden, place):
    results = golden.copy(place)
    report = results / "two/report.json"
    whole = report.read_text()
    report.write_text(whole.replace('"stplan": "', '"stplan": "9'))
    # With a manifest that fits: it is not for a damaged file that the run is planned again.
    record = results / "two/run.json"
    digests = [hashlib.sha256(text.encode()).hexdigest() for text in (whole, report.read_text())]
    record.write_text(record.read_text().replace(*digests))
    assert "plan     two: planned by other versions" in _batch(place, "--dry-run").out
    assert _batch(place, "--dry-run", "--force").out.count("--force") == 4
    ended = _batch(place, "--jobs", 1, "--force", "--filter", "t*")
    assert ended.status == 0, ended.err
    assert "done before" not in ended.err
    assert report.read_text() == whole


def test_one_bad_scene_and_one_blocked_do_not_hold_up_the_others(place):
    scenes = place / "scenes"
    (scenes / "one.yaml").write_text((scenes / "one.yaml").read_text().replace("radius", "radios"))
    (scenes / "room.yaml").write_text(
        (scenes / "room.yaml").read_text().replace("room.obj}", "room.obj, obstacles: [{rectangle: "
        "[3.0, -1.0, 3.5, 4.0]}]}")
    )  # fmt: skip
    ended = _batch(place, "--jobs", 1, "--output-format", "junit")
    assert ended.status == 2
    (suite,) = ElementTree.fromstring(ended.out)
    states = {
        case.get("name"): [child.get("type") for child in case if child.get("type")]
        for case in suite
    }
    assert states == {"scenes/one.yaml": ["refused"], "room": ["no seed"], "three": [], "two": []}
    assert "scenes/one.yaml:4:" in ended.err
    assert "room: " in ended.err
    summary = json.loads((place / "results/batch.json").read_text())
    assert [run["exit_status"] for run in summary["runs"]] == [2, 3, 0, 0]
    # The certified ones are done; what failed is tried again, and fails again.
    ended = _batch(place, "--jobs", 1, "--filter", "t*")
    assert (ended.status, ended.err.count("done before")) == (0, 2)
    ended = _batch(place, "--jobs", 1, "--filter", "room")
    assert ended.status == 3


def test_fail_fast_ends_at_the_first_failure(place):
    (place / "scenes/one.yaml").write_text("stplan: 1\n")
    ended = _batch(place, "--fail-fast", "--json")
    assert ended.status == 2
    assert ended.json["exit_status"] == 2
    assert [run["state"] for run in ended.json["runs"]] == ["refused"] + ["not run"] * 3
    assert not (place / "results/two").exists()


def test_a_run_that_takes_too_long_gives_its_best_so_far(place):
    ended = _batch(
        place, "--filter", "two", "--timeout", 2, *ENDLESS, "--output-format", "github"
    )  # fmt: skip
    assert ended.status == 4
    assert "::error file=scenes/two.yaml,title=two%3A timeout::stopped after 2 s" in ended.out
    assert stplan("check", "results/two", cwd=place).status == 0
    preview = _batch(place, "--filter", "two", *ENDLESS, "--dry-run")
    assert preview.out == "plan     two: it was interrupted\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--timeout", "nan"], "--timeout is nan"),
        (["--sweep", "mu"], "--sweep mu: KEY=VALUE,VALUE"),
        (["none"], "cannot read none: no such file"),
    ],
)
def test_a_wrong_command_line(run, place, monkeypatch, arguments, message):
    monkeypatch.chdir(place)
    result = run("batch", "scenes", "-o", "results", *arguments)
    assert result.status == 2
    assert message in result.err
