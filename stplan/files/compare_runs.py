"""Where two runs differ, or two folders of runs: trajectories and certificates together."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stplan.errors import UsageError
from stplan.files.compare import Difference, compare_trajectories
from stplan.files.compare_reports import Change, compare_verdicts
from stplan.files.recorded import REPORT, RecordedReport, read_report
from stplan.files.trajectories import TRAJECTORIES, read_trajectories


@dataclass(frozen=True)
class RunDifference:
    """How one run differs.

    Attributes:
        run: its folder, relative to what was named; empty where a single run was named.
        trajectories: how its curves differ.
        certificate: what its report says otherwise; None where not both have a report.
    """

    run: str
    trajectories: Difference
    certificate: tuple[Change, ...] | None

    @property
    def equal(self) -> bool:
        """Equal trajectories within the tolerances, and the same verdict on them."""
        return self.trajectories.equal and not self.certificate

    def lines(self) -> list[str]:
        """A sentence for everything that differs, one if nothing does."""
        changes = [change.sentence() for change in self.certificate or ()]
        if changes and self.trajectories.equal:
            return changes
        return changes + self.trajectories.lines()

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        changes = self.certificate
        return {
            "equal": self.equal,
            **({"run": self.run} if self.run else {}),
            "certificate": None if changes is None else [change.as_dict() for change in changes],
            **{k: v for k, v in self.trajectories.as_dict().items() if k != "equal"},
        }


@dataclass(frozen=True)
class RunsDifference:
    """How two folders of runs differ; the first is what was expected.

    Attributes:
        missing: runs of the first only.
        added: runs of the second only.
        runs: those of both, in order of their folders.
    """

    missing: tuple[str, ...]
    added: tuple[str, ...]
    runs: tuple[RunDifference, ...]

    @property
    def equal(self) -> bool:
        """The same runs, all of them equal."""
        return not (self.missing or self.added) and all(run.equal for run in self.runs)

    @property
    def summary(self) -> str:
        """How many are equal, in one line."""
        num_equal = sum(run.equal for run in self.runs)
        parts = [f"{num_equal} of {len(self.runs)} common runs equal"]
        parts += [f"{len(self.missing)} missing"] if self.missing else []
        parts += [f"{len(self.added)} added"] if self.added else []
        return ", ".join(parts)

    def lines(self) -> list[str]:
        """A sentence for everything that differs, under the name of its run, then a summary."""
        lines = [f"{run}: only in the first" for run in self.missing]
        lines += [f"{run}: only in the second" for run in self.added]
        for run in self.runs:
            if not run.equal:
                lines += [f"{run.run}:", *(f"  {line}" for line in run.lines())]
        return [*lines, self.summary]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "equal": self.equal,
            "missing_runs": list(self.missing),
            "added_runs": list(self.added),
            "runs": [run.as_dict() for run in self.runs],
        }


def compare_runs(
    a: Path, b: Path, atol: float = 1e-9, rtol: float = 0.0
) -> RunDifference | RunsDifference:
    """Compare `b` with `a`: two runs (files, or folders that hold trajectories), or two folders of such.

    Certificates are compared where both are folders with a report.json.

    Raises:
        UsageError: something cannot be read, or only one of them is a folder of runs.
    """
    several = [path for path in (a, b) if path.is_dir() and not _is_run(path)]
    if not several:
        return _compare_run("", a, b, atol, rtol)
    for path in several:
        if not _runs_below(path):
            read_trajectories(path)  # Says what is missing there.
    if len(several) == 1:
        raise UsageError(f"{several[0]} is a folder of runs; expected two of them, or two runs")
    first, second = _runs_below(a), _runs_below(b)
    return RunsDifference(
        missing=tuple(run for run in first if run not in second),
        added=tuple(run for run in second if run not in first),
        runs=tuple(
            _compare_run(run, first[run], second[run], atol, rtol) for run in first if run in second
        ),
    )


def _is_run(folder: Path) -> bool:
    return any((folder / name).is_file() for name in TRAJECTORIES)


def _runs_below(folder: Path) -> Mapping[str, Path]:
    """Every folder with trajectories below `folder`, by its relative name, in order."""
    found = {}
    for place, _, files in os.walk(folder):
        if set(TRAJECTORIES) & set(files):
            path = Path(place)
            found[path.relative_to(folder).as_posix()] = path
    return dict(sorted(found.items()))


def _certified(path: Path) -> RecordedReport:
    """The report at `path`; raises UsageError where it holds no certificate."""
    report = read_report(path)
    if report.holds is None:
        raise UsageError(f"{path}: certificate: expected what stplan solve writes")
    return report


def _compare_run(run: str, a: Path, b: Path, atol: float, rtol: float) -> RunDifference:
    difference = compare_trajectories(read_trajectories(a), read_trajectories(b), atol, rtol)
    reports = [path / REPORT for path in (a, b)]
    if not all(report.is_file() for report in reports):
        return RunDifference(run, difference, None)
    moved = {
        agent.agent: agent.simultaneous.amount
        for agent in difference.agents
        if agent.simultaneous is not None
    }
    first, second = map(_certified, reports)
    return RunDifference(run, difference, compare_verdicts(first, second, moved, atol, rtol))
