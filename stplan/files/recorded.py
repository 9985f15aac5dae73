"""What report.json and run.json say of a run, read back: the one reader of both for all commands.

What a file leaves out is None or empty, because runs of other versions are read too; what is there in
another form is an error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from stplan.errors import UsageError
from stplan.files.json_file import read_json

REPORT = "report.json"
RUN_RECORD = "run.json"

# Whom the rows of a certificate's tables concern, and the columns where it does not name them itself.
_WHO = {"pairs": ["a", "b"], "walls": ["agent"]}
_OTHERS = ["clearance", "time", "x", "y"]


@dataclass(frozen=True)
class RecordedReport:
    """A report.json, as far as commands ask it.

    Attributes:
        source, content_hash, overrides: of the scene.
        holds: whether the certificate does.
        clearances: least clearance (m) of everything demanded, by whom it concerns: two agents, or
            one and the walls.
        others_above, walls_above: what the clearance of every pair that is not listed exceeds (m), and that
            of every agent to walls which is not; None where all are listed.
        latest_arrival: s.
        costs: of every term at the end.
        iterations: of all outer iterations together.
    """

    status: str | None = None
    advice: str = ""
    source: str | None = None
    content_hash: str | None = None
    overrides: tuple[str, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    holds: bool | None = None
    clearances: Mapping[tuple[str, ...], float] = field(default_factory=dict)
    others_above: float | None = None
    walls_above: float | None = None
    latest_arrival: float | None = None
    kinetic_over_straight: float | None = None
    costs: Mapping[str, float] = field(default_factory=dict)
    iterations: int | None = None

    @property
    def smallest_clearance(self) -> float | None:
        """The smallest of all demanded clearances, m; None where nothing interacts."""
        return min(self.clearances.values(), default=None)

    def clearance(self, who: tuple[str, ...], expected: float | None) -> float | None:
        """That of `who`; where it is not listed, what is nearest to `expected` of all it can be."""
        listed = self.clearances.get(who)
        above = self.others_above if len(who) > 1 else self.walls_above
        if listed is not None or above is None or expected is None:
            return listed
        return max(expected, above)


@dataclass(frozen=True)
class RecordedTimes:
    """A run.json: when planning began, and the seconds of its stages and in total."""

    started: datetime | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)

    @property
    def total(self) -> float | None:
        """Seconds of planning."""
        return self.seconds.get("total")


def read_report(path: Path) -> RecordedReport:
    """Read a report.json.

    Raises:
        UsageError: it cannot be read, or is not what `stplan solve` writes.
    """
    return parse_report(read_json(path), path)


def read_times(path: Path) -> RecordedTimes:
    """Read a run.json. Raises like `read_report`."""
    return parse_times(read_json(path), path)


def parse_report(content: Mapping[str, Any], path: Path) -> RecordedReport:
    """What the `content` of a report.json says; `path` heads what is wrong with it."""
    with _reading(path, "scene"):
        scene = content.get("scene") or {}
        source, content_hash = scene.get("source"), scene.get("hash")
        overrides = scene.get("overrides", [])
    if not isinstance(overrides, list) or not all(isinstance(item, str) for item in overrides):
        raise UsageError(f"{path}: scene.overrides: expected a list of KEY=VALUE")
    with _reading(path, "certificate"):
        certificate = content.get("certificate")
        holds = None if certificate is None else _flag(certificate["holds"])
        clearances = {} if certificate is None else _clearances(certificate)
        above = {name: None if certificate is None else _above(certificate[name]) for name in _WHO}
    with _reading(path, "metrics"):
        metrics = content.get("metrics") or {}
        arrival, kinetic = metrics.get("latest_arrival"), metrics.get("kinetic_over_straight")
    with _reading(path, "outer_iterations"):
        loops = content.get("outer_iterations")
        iterations = None if loops is None else sum(int(loop["iterations"]) for loop in loops)
    return RecordedReport(
        status=content.get("status"),
        advice=content.get("advice") or "",
        source=source if isinstance(source, str) else None,
        content_hash=content_hash if isinstance(content_hash, str) else None,
        overrides=tuple(overrides),
        versions=content.get("versions") or {},
        holds=holds,
        clearances=clearances,
        others_above=above["pairs"],
        walls_above=above["walls"],
        latest_arrival=arrival,
        kinetic_over_straight=kinetic,
        costs=content.get("costs") or {},
        iterations=iterations,
    )


def parse_times(content: Mapping[str, Any], path: Path) -> RecordedTimes:
    """What the `content` of a run.json says; `path` heads what is wrong with it."""
    with _reading(path, "started"):
        started = content.get("started")
        began = None if started is None else datetime.fromisoformat(started)
    with _reading(path, "seconds"):
        return RecordedTimes(began, {**(content.get("seconds") or {})})


def _above(table: Mapping[str, Any]) -> float | None:
    """What clearances that a table does not list exceed, None where it lists all."""
    others = table.get("others")
    return None if others is None else float(others["clearance_above"])


def _clearances(certificate: Mapping[str, Any]) -> dict[tuple[str, ...], float]:
    """By name of the column, wherever it stands."""
    found = {}
    for table, who in _WHO.items():
        columns = certificate[table].get("columns", who + _OTHERS)
        for row in certificate[table]["rows"]:
            cells = dict(zip(columns, row, strict=True))
            found[tuple(str(cells[name]) for name in who)] = float(cells["clearance"])
    return found


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


@contextmanager
def _reading(path: Path, section: str) -> Iterator[None]:
    try:
        yield
    except (AttributeError, KeyError, IndexError, TypeError, ValueError) as error:
        raise UsageError(f"{path}: {section}: expected what stplan solve writes") from error
