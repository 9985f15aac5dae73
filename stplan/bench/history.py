"""A scoreboard that lasts: what benchmarks took, by commit and machine, in units of a fixed loop.

Seconds of two machines, or of two days on one, do not compare; how many times longer something took than a
fixed loop beside it does. The loop is of the kinds of work that planning is: dense linear algebra in numpy,
and the interpreter. It must stay as it is, or records from before and after would not compare.
"""

from __future__ import annotations

import csv
import os
import subprocess
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from datetime import date
from pathlib import Path
from statistics import median

import numpy as np

from stplan.arrays import FloatArray
from stplan.bench.csv_table import csv_table
from stplan.bench.machine import processor
from stplan.bench.markdown import number, table
from stplan.callbacks import Progress
from stplan.errors import UsageError
from stplan.files.atomic import write_atomically

# The files of benchmarks: columns that name a case, and the one with its seconds.
SOURCES = {
    "startup": (("command",), "processor"),
    "figures": (("figure",), "total_seconds"),
    "agents": (("size",), "total_seconds"),
    "knots": (("size",), "total_seconds"),
    "walls": (("size",), "total_seconds"),
    "seeding": (("family",), "cpu_seconds"),
}
ROUNDS = 7
# Ratios that differ by less than this are the same.
NOISE = 0.1
# So many records of a case are shown.
SHOWN = 8


@dataclass(frozen=True)
class HistoryEntry:
    """What a case took once.

    Attributes:
        day: ISO 8601.
        commit: short, with a + where the tree differed from it; empty where there is none.
        machine: processor and number of cores; no name of a host.
        loop: processor seconds of the fixed loop beside it.
        benchmark, case: what was measured.
        seconds: it took, the median of its draws.
        ratio: seconds over loop.
    """

    day: str
    commit: str
    machine: str
    loop: float
    benchmark: str
    case: str
    seconds: float
    ratio: float


def fixed_loop() -> float:
    """Processor seconds of the loop, the least of several rounds."""
    matrix = np.random.default_rng(0).normal(size=(220, 220)) + 30.0 * np.eye(220)
    taken = []
    for _ in range(ROUNDS):
        began = time.process_time()
        right: FloatArray = np.ones(220)
        for _ in range(12):
            right = np.asarray(np.linalg.solve(matrix, right) + 1.0, dtype=np.float64)
        total = 0
        for k in range(120_000):
            total += k % 7
        taken.append(time.process_time() - began)
    return min(taken)


def commit_of(folder: Path) -> str:
    """The commit that `folder` is at, empty where it is under no version control."""
    try:
        said = [
            subprocess.run(
                ["git", *words], cwd=folder, capture_output=True, text=True, check=True
            ).stdout.strip()
            for words in (("rev-parse", "--short=10", "HEAD"), ("status", "--porcelain"))
        ]
    except (OSError, subprocess.CalledProcessError):
        return ""
    return said[0] + ("+" if said[1] else "")


def measured_in(folder: Path, loop: float) -> list[HistoryEntry]:
    """What the benchmarks left in `folder`, a median a case; draws that failed count for nothing."""
    place = (date.today().isoformat(), commit_of(Path(__file__).parent), machine())
    found = []
    for benchmark, (names, column) in SOURCES.items():
        path = folder / f"{benchmark}.csv"
        if not path.exists():
            continue
        cases: dict[str, list[float]] = {}
        with path.open(newline="", encoding="utf-8") as stream:
            for row in csv.DictReader(stream):
                if row[column]:
                    case = " ".join(row[name] for name in names)
                    cases.setdefault(case, []).append(float(row[column]))
        for case, taken in cases.items():
            seconds = median(taken)
            found.append(HistoryEntry(*place, loop, benchmark, case, seconds, seconds / loop))
    return found


def machine() -> str:
    """Processor and cores."""
    return f"{processor()} x {os.cpu_count()}"


def read_history(path: Path) -> list[HistoryEntry]:
    """All entries, the oldest first; none where there is no such file yet.

    Raises:
        UsageError: it is no history.
    """
    if not path.exists():
        return []
    names = [one.name for one in fields(HistoryEntry)]
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream, strict=True)
            if list(reader.fieldnames or ()) != names:
                raise ValueError(f"expected the columns {', '.join(names)}")
            return [
                HistoryEntry(
                    row["day"], row["commit"], row["machine"], float(row["loop"]), row["benchmark"],
                    row["case"], float(row["seconds"]), float(row["ratio"]),
                )
                for row in reader
            ]  # fmt: skip
    except (OSError, UnicodeDecodeError, ValueError, TypeError, csv.Error) as error:
        raise UsageError(f"{path} is no history of benchmarks: {error}") from error


def compared(history: Sequence[HistoryEntry], found: Sequence[HistoryEntry]) -> str:
    """A row a case: its ratio to the loop, and how it changed since it was last recorded."""
    last = {(one.benchmark, one.case): one for one in history}
    rows = []
    for one in found:
        before = last.get((one.benchmark, one.case))
        change = "new" if before is None else _change(one.ratio / before.ratio)
        since = "" if before is None else f"{before.commit or before.day}"
        rows.append((one.benchmark, one.case, number(one.ratio, ".1f"), change, since))
    return table(("benchmark", "case", "times the loop", "change", "since"), rows, {0, 1, 4})


def trends(history: Sequence[HistoryEntry]) -> str:
    """Markdown, a row a case: how its ratio to the loop went from record to record, the oldest first."""
    cases: dict[tuple[str, str], list[HistoryEntry]] = {}
    for one in history:
        cases.setdefault((one.benchmark, one.case), []).append(one)
    rows = []
    for (benchmark, case), records in cases.items():
        ratios = [one.ratio for one in records]
        last = records[-1]
        change = "new" if len(records) == 1 else _change(ratios[-1] / ratios[0])
        shown = ", ".join(number(ratio, ".3g") for ratio in ratios[-SHOWN:])
        rows.append((benchmark, case, shown, change, f"{last.day} {last.commit}".strip()))
    heads = ("benchmark", "case", "times the loop", "change since the first", "last record")
    return table(heads, rows, {0, 1, 2, 4})


def _change(ratio: float) -> str:
    if abs(ratio - 1.0) < NOISE:
        return "="
    return f"{ratio:.2f} times"


def record(folder: Path, path: Path, *, progress: Progress, loop: float | None = None) -> str:
    """Append what is in `folder` to the history at `path`; Markdown that compares it with what was.

    Raises:
        UsageError: it is no history, or there is nothing to record.
    """
    history = read_history(path)
    found = measured_in(folder, fixed_loop() if loop is None else loop)
    if not found:
        raise UsageError(f"{folder} holds no benchmark to be recorded")
    write_atomically(path, csv_table([asdict(one) for one in (*history, *found)]).encode())
    progress(f"recorded {len(found)} cases in {path}")
    return compared(history, found)
