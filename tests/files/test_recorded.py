"""What report.json and run.json say is read back by name, wherever it stands."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from stplan.bench.families_open import circle
from stplan.errors import UsageError
from stplan.files.json_file import json_bytes
from stplan.files.recorded import (
    RecordedReport,
    RecordedTimes,
    parse_report,
    parse_times,
    read_report,
    read_times,
)
from stplan.planner import plan, write_plan

HERE = Path("runs/x/report.json")


def report(**parts: Any) -> RecordedReport:
    return parse_report(parts, HERE)


def test_what_a_plan_writes_is_what_is_read(tmp_path):
    planned = plan(circle(3, 3.0, 10.0))
    write_plan(planned, tmp_path)
    found = read_report(tmp_path / "report.json")
    smallest = planned.certificate.smallest
    assert smallest is not None
    assert found.status == planned.status
    assert found.holds is True
    assert found.smallest_clearance == smallest.clearance
    assert found.clearances == {spot.who: spot.clearance for spot in planned.certificate.pairs}
    assert found.kinetic_over_straight is not None
    assert found.kinetic_over_straight >= 1.0
    assert found.latest_arrival is not None
    assert 0 < found.latest_arrival <= 10.0
    assert found.costs.keys() >= {"kinetic", "collision"}
    assert found.iterations is not None
    assert found.iterations > 0
    assert found.versions.keys() >= {"stplan", "ipopt"}
    times = read_times(tmp_path / "run.json")
    assert times.started is not None
    assert times.total is not None
    assert times.seconds.keys() == {"world", "seed", "optimise", "certify", "bound", "total"}
    stages = [amount for name, amount in times.seconds.items() if name != "total"]
    assert 0 < sum(stages) <= times.total * (1 + 1e-9)


def test_columns_are_read_by_their_names():
    certificate = {
        "holds": True,
        "pairs": {"columns": ["a", "b", "time", "clearance"], "rows": [["sam", "ann", 3.0, 0.25]]},
        "walls": {"columns": ["agent", "clearance"], "rows": [["sam", 0.5]]},
    }
    found = report(certificate=certificate)
    assert found.clearances == {("sam", "ann"): 0.25, ("sam",): 0.5}
    assert found.smallest_clearance == 0.25


def test_what_is_left_out_is_unknown():
    assert report() == RecordedReport()
    assert (report().holds, report().smallest_clearance, report().iterations) == (None, None, None)
    assert parse_times({}, HERE) == RecordedTimes()
    assert RecordedTimes().total is None


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"certificate": {"holds": "yes"}}, "certificate: expected what stplan solve writes"),
        ({"certificate": {"holds": True}}, "certificate: expected"),
        (
            {"certificate": {"holds": True, "pairs": {"rows": [["a"]]}, "walls": {"rows": []}}},
            "certificate: expected",
        ),
        ({"metrics": [1]}, "metrics: expected"),
        ({"scene": 3}, "scene: expected"),
        ({"scene": {"overrides": [3]}}, r"scene\.overrides: expected a list of KEY=VALUE"),
        ({"outer_iterations": [{}]}, "outer_iterations: expected"),
    ],
)
def test_what_has_another_form_is_refused_with_its_place(parts, words):
    with pytest.raises(UsageError, match=rf"^runs/x/report\.json: {words}"):
        report(**parts)


def test_times_in_another_form_are_refused(tmp_path):
    path = tmp_path / "run.json"
    path.write_bytes(json_bytes({"started": "2026-01-01T00:00:00+00:00", "seconds": {"total": 2}}))
    assert read_times(path) == RecordedTimes(datetime(2026, 1, 1, tzinfo=UTC), {"total": 2})
    for content, words in (({"started": "soon"}, "started"), ({"seconds": 3}, "seconds")):
        path.write_bytes(json_bytes(content))
        with pytest.raises(UsageError, match=f"{words}: expected"):
            read_times(path)
