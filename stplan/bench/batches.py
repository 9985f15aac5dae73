"""What a batch costs beyond planning, and what a second process brings: `stplan batch`, run as it is.

The runs are eight agents that change places on a circle, each with another seed of the random
generator. All times come from the clock around the command and from the run.json of its runs.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timedelta
from pathlib import Path

from stplan.bench.csv_table import csv_table
from stplan.bench.machine import description
from stplan.bench.markdown import table
from stplan.bench.result_files import result_files
from stplan.callbacks import Progress
from stplan.errors import UsageError
from stplan.files.recorded import RUN_RECORD, read_times

# What is asked: seconds a run beyond planning it, and how many times the runs of one process two do.
ASKED_OVERHEAD = 0.05
ASKED_GAIN = 1.7

SCENE = """\
stplan: 1
name: circle-8
horizon: 90.0
defaults: {radius: 0.5, after_arrival: vanish}
agents:
  - {pattern: circle, id: agent, count: 8, circle: {center: [0.0, 0.0], radius: 45.0}}
"""


@dataclass(frozen=True)
class MeasuredBatch:
    """One batch. Times in s.

    Attributes:
        wall: of the whole command, its start included.
        planning: sum over all runs.
        overhead: a run, from the end of the first run to the end of the last; with one job only.
    """

    jobs: int
    runs: int
    certified: int
    wall: float
    planning: float
    overhead: float | None

    @property
    def throughput(self) -> float:
        """Runs a second."""
        return self.runs / self.wall


def measure(num_runs: int, jobs: Sequence[int], *, progress: Progress) -> list[MeasuredBatch]:
    """The same batch with each number of `jobs`.

    Raises:
        UsageError: a batch ended early.
    """
    measured = []
    with tempfile.TemporaryDirectory(prefix="stplan-bench-") as name:
        scene = Path(name) / "circle-8.yaml"
        scene.write_text(SCENE, encoding="utf-8")
        # Machine code that has to be made first is no part of the figures.
        _batch(scene, 1, 1, Path(name) / "warm")
        for number in jobs:
            folder = Path(name) / f"jobs-{number}"
            wall = _batch(scene, num_runs, number, folder)
            measured.append(_read(folder, number, wall))
            progress(f"{num_runs} runs with --jobs {number}: {wall:.2f} s")
    return measured


def _batch(scene: Path, num_runs: int, jobs: int, folder: Path) -> float:
    """Run a batch; its wall time in s."""
    seeds = ",".join(map(str, range(num_runs)))
    command = [sys.executable, "-m", "stplan", "batch", str(scene), "-o", str(folder)]
    started = time.perf_counter()
    ended = subprocess.run(
        [*command, "--jobs", str(jobs), "--sweep", f"seeding.rng_seed={seeds}", "--quiet"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    wall = time.perf_counter() - started
    if not (folder / "batch.json").exists():
        raise UsageError(f"the batch ended early: {ended.stderr.strip()}")
    return wall


def _read(folder: Path, jobs: int, wall: float) -> MeasuredBatch:
    runs = json.loads((folder / "batch.json").read_text(encoding="utf-8"))["runs"]
    spans = sorted(_span(folder / run["run"]) for run in runs if run["exit_status"] == 0)
    planning = [(end - start).total_seconds() for start, end in spans]
    overhead = None
    if jobs == 1 and len(spans) > 1:
        after_first = (spans[-1][1] - spans[0][1]).total_seconds()
        overhead = (after_first - sum(planning[1:])) / (len(spans) - 1)
    return MeasuredBatch(jobs, len(runs), len(spans), wall, sum(planning), overhead)


def _span(folder: Path) -> tuple[datetime, datetime]:
    """When planning a run began and ended."""
    times = read_times(folder / RUN_RECORD)
    if times.started is None or times.total is None:
        raise UsageError(f"{folder / RUN_RECORD}: says neither when it began nor how long it took")
    return times.started, times.started + timedelta(seconds=times.total)


def files(measured: Sequence[MeasuredBatch]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    rows = [asdict(one) | {"throughput": one.throughput} for one in measured]
    return result_files("batch", csv_table(rows), markdown_text(measured))


def markdown_text(measured: Sequence[MeasuredBatch]) -> str:
    """A row a batch, what is asked, and the machine."""
    first = measured[0]
    rows = [
        (
            str(one.jobs),
            f"{one.certified} of {one.runs}",
            f"{one.wall:.2f}",
            f"{one.planning:.2f}",
            "-" if one.overhead is None else f"{1e3 * one.overhead:.1f}",
            f"{one.throughput:.2f}",
            f"{one.throughput / first.throughput:.2f}",
        )
        for one in measured
    ]
    head = (
        "jobs", "certified", "wall s", "planning s", "overhead ms a run", "runs a second",
        f"times --jobs {first.jobs}",
    )  # fmt: skip
    asked = (
        f"Asked: an overhead below {1e3 * ASKED_OVERHEAD:.0f} ms a run with one job, after the first "
        f"run; with two jobs on two idle cores {ASKED_GAIN:g} times the runs a second of one.\n"
    )
    return "\n".join([table(head, rows, words=()), asked, description()])
