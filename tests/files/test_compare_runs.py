"""Runs and folders of runs are compared as a whole, certificates included."""

from __future__ import annotations

import json

import pytest

from stplan.errors import UsageError
from stplan.files.compare_markdown import MOST_SENTENCES, markdown_lines
from stplan.files.compare_runs import RunDifference, RunsDifference, compare_runs
from stplan.files.csv_file import csv_bytes
from stplan.files.json_file import json_bytes
from tests.files.examples import scene_of, straight_lines

ROWS = {"sam": 0.5, "ann": 0.25}


def report(status="converged", holds=True, pair=0.125, walls=ROWS):
    certificate = {
        "holds": holds,
        "pairs": {"rows": [["sam", "ann", pair, 1.0, 0.0, 0.0]] if pair is not None else []},
        "walls": {"rows": [[name, gap, 1.0, 0.0, 0.0] for name, gap in walls.items()]},
    }
    return {"status": status, "certificate": certificate}


def write(folder, verdict=None, moved=0.0, ids=("sam", "ann")):
    """A run's folder; its first agent stands `moved` (m) aside in the middle."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = straight_lines(scene_of(list(ids)))
    lines.knots[1, 1] += moved
    (folder / "trajectories.csv").write_bytes(csv_bytes(lines))
    if verdict is not None:
        (folder / "report.json").write_bytes(json_bytes(verdict))
    return folder


def test_a_run_equals_itself(tmp_path):
    run = write(tmp_path / "a", report())
    difference = compare_runs(run, run, atol=0.0)
    assert isinstance(difference, RunDifference)
    assert difference.equal
    assert difference.certificate == ()
    assert difference.lines() == ["equal: 2 agents"]


@pytest.mark.parametrize(
    ("verdict", "sentences"),
    [
        (report(status="limit"), ["status: converged -> limit"]),
        (report(holds=False), ["certificate holds: yes -> no"]),
        (report(pair=None), ["clearance of sam and ann: 0.125 m -> none"]),
        (report(pair=0.25), ["clearance of sam and ann: 0.125 m -> 0.25 m"]),
        (
            report(walls={"sam": 0.5, "eve": 1.0}),
            [
                "clearance of ann to the walls: 0.25 m -> none",
                "clearance of eve to the walls: none -> 1 m",
            ],
        ),
    ],
)
def test_what_a_certificate_says_otherwise(tmp_path, verdict, sentences):
    a, b = write(tmp_path / "a", report()), write(tmp_path / "b", verdict)
    difference = compare_runs(a, b)
    assert not difference.equal
    assert difference.lines() == sentences
    assert not compare_runs(b, a).equal


def test_pairs_that_large_reports_leave_out_are_further_apart_than_the_rest(tmp_path):
    def large(pair, above):
        verdict = report(pair=pair)
        verdict["certificate"]["pairs"]["others"] = {"pairs": 9, "clearance_above": above}
        return verdict

    a = write(tmp_path / "a", large(0.125, 0.3))
    # Left out, it may still be what it was.
    b = write(tmp_path / "b", large(None, 0.125))
    assert compare_runs(a, b).equal
    assert compare_runs(b, a).equal
    # Left out, it must have grown.
    (tmp_path / "b" / "report.json").write_bytes(json_bytes(large(None, 0.25)))
    assert compare_runs(a, b).lines() == ["clearance of sam and ann: 0.125 m -> 0.25 m"]
    assert not compare_runs(b, a).equal


def test_clearances_may_change_as_much_as_the_agents_moved(tmp_path):
    a, b = write(tmp_path / "a", report()), write(tmp_path / "b", report(pair=0.12), moved=0.01)
    assert compare_runs(a, b, atol=0.02).equal
    (tmp_path / "b" / "report.json").write_bytes(json_bytes(report(pair=0.05)))
    (change,) = compare_runs(a, b, atol=0.02).certificate
    assert change.as_dict() == {
        "subject": "clearance of sam and ann", "first": 0.125, "second": 0.05,
    }  # fmt: skip


def test_without_two_reports_certificates_are_not_compared(tmp_path):
    a, b = write(tmp_path / "a", report()), write(tmp_path / "b")
    for first, second in ((a, b), (b, a), (a / "trajectories.csv", a)):
        difference = compare_runs(first, second)
        assert difference.equal
        assert difference.certificate is None
        assert "| not compared |" in markdown_lines(difference)[4]


def test_folders_of_runs(tmp_path):
    for tree in ("a", "b"):
        write(tmp_path / tree / "gap", report())
        write(tmp_path / tree / "deep" / "door", report())
    write(tmp_path / "a" / "old", report())
    write(tmp_path / "b" / "new", report())
    write(tmp_path / "b" / "gap", report(), moved=0.5)
    difference = compare_runs(tmp_path / "a", tmp_path / "b")
    assert isinstance(difference, RunsDifference)
    assert (difference.missing, difference.added) == (("old",), ("new",))
    assert [(run.run, run.equal) for run in difference.runs] == [
        ("deep/door", True), ("gap", False),
    ]  # fmt: skip
    lines = difference.lines()
    assert lines[:3] == ["old: only in the first", "new: only in the second", "gap:"]
    assert lines[3].startswith("  sam: position 0.5 m at knot 1 (t = 2.5 s)")
    assert lines[-1] == "1 of 2 common runs equal, 1 missing, 1 added"
    content = json.loads(json_bytes(difference.as_dict()))
    assert (content["equal"], content["missing_runs"], content["added_runs"]) == (
        False, ["old"], ["new"],
    )  # fmt: skip
    assert content["runs"][1]["agents"][0]["position"]["amount"] == 0.5


def test_only_missing_runs_are_a_difference(tmp_path):
    write(tmp_path / "a" / "gap")
    write(tmp_path / "b" / "gap")
    write(tmp_path / "b" / "new")
    assert not compare_runs(tmp_path / "a", tmp_path / "b").equal
    assert not compare_runs(tmp_path / "b", tmp_path / "a").equal


def test_what_cannot_be_compared(tmp_path):
    run = write(tmp_path / "runs" / "gap", report())
    with pytest.raises(UsageError, match="runs is a folder of runs; expected two of them"):
        compare_runs(tmp_path / "runs", run)
    (tmp_path / "empty").mkdir()
    with pytest.raises(UsageError, match=r"empty: holds no trajectories\.npz"):
        compare_runs(tmp_path / "empty", run)
    with pytest.raises(UsageError, match="no such file"):
        compare_runs(run, tmp_path / "none")
    for content in ({}, {"certificate": 3}, {"certificate": {"holds": True, "pairs": {"rows": 3}}}):
        (run / "report.json").write_bytes(json_bytes(content))
        with pytest.raises(UsageError, match=r"report\.json: certificate: expected"):
            compare_runs(run, run)


def test_markdown(tmp_path):
    ids = [f"a|{k}" for k in range(MOST_SENTENCES + 3)]
    a, b = write(tmp_path / "a" / "g_p", ids=ids), write(tmp_path / "b" / "g_p", moved=0.5, ids=ids)
    write(tmp_path / "a" / "lost")
    assert markdown_lines(compare_runs(a, b))[0] == "### stplan diff: different"
    lines = markdown_lines(compare_runs(tmp_path / "a", tmp_path / "b"))
    assert lines[0] == "### stplan diff: 0 of 1 common runs equal, 1 missing"
    assert lines[4] == (
        "| g\\_p | 23 | 0.5 (a\\|0, t = 2.5 s) | 0 | 0.5 (a\\|0, t = 2.5 s) | not compared |"
    )
    assert lines[5] == "| lost | only in the first | | | | |"
    assert "**g\\_p**" in lines
    # Every row has the columns of the head.
    assert {line.replace("\\|", "").count("|") for line in lines[2:6]} == {7}
    few = write(tmp_path / "few", ids=["eve"])
    assert markdown_lines(compare_runs(a, few))[-1] == "- and 4 more"
