"""batch.csv and batch.json: how the runs of a folder stand, a row a run.

They tell what is, not how it came about: a batch that was killed and taken up again ends with the
rows of one that never was, wall times excepted, which stand last.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from stplan.batch.result import Batch, Result
from stplan.files.atomic import write_set
from stplan.files.json_file import json_bytes

SUMMARIES = ("batch.csv", "batch.json")
_PHASES = ("world", "seed", "optimise", "certify")


def write_summary(folder: Path, batch: Batch) -> list[Path]:
    """Write both files into `folder` and return their paths; raises UsageError."""
    contents = (_csv_bytes(batch.results), json_bytes(summary(batch)))
    return write_set(folder, dict(zip(SUMMARIES, contents, strict=True)))


def summary(batch: Batch) -> dict[str, Any]:
    """What batch.json holds."""
    return {
        "format": 1,
        "stplan": metadata.version("stplan"),
        "counts": batch.counts,
        "runs": [_entry(result) for result in batch.results],
    }


def _entry(result: Result) -> dict[str, Any]:
    report = result.report
    return {
        "run": result.run.name,
        "scene": str(result.run.source),
        "overrides": list(result.run.overrides),
        "hash": result.run.content_hash or None,
        "state": result.state,
        "exit_status": result.exit_status,
        "status": report.status,
        "certificate_holds": bool(report.holds),
        "smallest_clearance": report.smallest_clearance,
        "latest_arrival": report.latest_arrival,
        "kinetic_over_straight": report.kinetic_over_straight,
        "iterations": report.iterations,
        "costs": report.costs,
        "messages": list(result.messages),
        "seconds": _seconds(result),
    }


def _seconds(result: Result) -> dict[str, float | None]:
    spent = result.times.seconds
    return {phase: spent.get(phase) for phase in _PHASES} | {"total": result.seconds}


def _csv_bytes(results: Sequence[Result]) -> bytes:
    entries = [_entry(result) for result in results]
    costs = list(dict.fromkeys(name for entry in entries for name in entry["costs"]))
    plain = (
        "run", "scene", "state", "exit_status", "status", "certificate_holds", "smallest_clearance",
        "latest_arrival", "kinetic_over_straight", "iterations", "hash",
    )  # fmt: skip
    seconds = (*_PHASES, "total")
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        [*plain, "overrides", "message"]
        + [f"cost_{name}" for name in costs]
        + [f"seconds_{name}" for name in seconds]
    )
    for entry in entries:
        writer.writerow(
            [_cell(entry[name]) for name in plain]
            + [" ".join(entry["overrides"]), " ".join(entry["messages"])]
            + [_cell(entry["costs"].get(name)) for name in costs]
            + [_cell(entry["seconds"][name]) for name in seconds]
        )
    # A name of a file in another encoding than UTF-8 cannot be written as it is.
    return text.getvalue().encode(errors="backslashreplace")


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)
