"""What a batch costs beyond planning."""

from __future__ import annotations

import csv
import json

import pytest

from stplan.bench import batches
from stplan.bench.batches import MeasuredBatch
from stplan.cli.app import main


def test_both_batches_are_measured_in_one_run(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["bench", "batch", "--runs", "3", "-o", str(tmp_path), "--quiet"])
    assert left.value.code == 0, capsys.readouterr().err
    one, two = csv.DictReader((tmp_path / "batch.csv").read_text().splitlines())
    assert [(row["jobs"], row["runs"], row["certified"]) for row in (one, two)] == [
        ("1", "3", "3"), ("2", "3", "3"),
    ]  # fmt: skip
    # All that one process plans is within the wall time, and so is what goes between.
    assert float(one["planning"]) + 2 * float(one["overhead"]) < float(one["wall"])
    assert float(one["overhead"]) > 0
    assert two["overhead"] == ""
    assert "Asked: an overhead below 50 ms" in (tmp_path / "batch.md").read_text()


def test_the_overhead_is_what_lies_between_the_runs(tmp_path):
    runs = []
    for number, (start, total) in enumerate([(10.0, 5.0), (15.5, 1.0), (16.75, 2.0)]):
        runs.append({"run": str(number), "exit_status": 0})
        (tmp_path / str(number)).mkdir()
        started = f"2026-01-01T00:00:{start:09.6f}+00:00"
        (tmp_path / str(number) / "run.json").write_text(
            json.dumps({"started": started, "seconds": {"total": total}})
        )
    (tmp_path / "batch.json").write_text(json.dumps({"runs": runs}))
    measured = batches._read(tmp_path, 1, 12.0)
    assert measured == MeasuredBatch(1, 3, 3, 12.0, 8.0, pytest.approx(0.375))
    assert batches._read(tmp_path, 2, 12.0).overhead is None
    assert "375.0" in batches.markdown_text([measured])
