"""The folder of a batch: who may write into it, and which of its runs are done."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from filelock import FileLock, Timeout

from stplan.batch.outcome import RunState
from stplan.batch.runs import Run
from stplan.errors import UsageError
from stplan.files.manifest import why_incomplete
from stplan.files.recorded import (
    REPORT,
    RUN_RECORD,
    RecordedReport,
    RecordedTimes,
    read_report,
    read_times,
)
from stplan.status import Status

LOCK = ".stplan-batch.lock"


@dataclass(frozen=True)
class Found:
    """What the folder of a run holds.

    Attributes:
        missing: why the run is to be planned (again); empty where it is done.
        state: of a run that is done, certified or failed.
        report, times: what its files say.
    """

    missing: str
    state: RunState = RunState.NOT_RUN
    report: RecordedReport = field(default_factory=RecordedReport)
    times: RecordedTimes = field(default_factory=RecordedTimes)

    @property
    def done(self) -> bool:
        """Planned from this very scene by this very program, to its end, with nothing lost."""
        return not self.missing


def found(run: Run, folder: Path) -> Found:
    """What `folder` holds of `run`."""
    missing = why_incomplete(folder)
    if missing:
        return Found(missing)
    try:
        report, times = read_report(folder / REPORT), read_times(folder / RUN_RECORD)
    except UsageError as error:
        return Found(str(error))
    if report.content_hash != run.content_hash:
        return Found("the scene, its mesh or its settings have changed")
    # Loaded late: where nothing is done yet, the workers alone need what plans.
    from stplan.report import versions

    if report.versions != versions():
        return Found("planned by other versions")
    exit_status = {one.value: one.exit_status for one in Status}.get(str(report.status), 130)
    if exit_status == 130 or not report.holds:
        return Found("it was interrupted")
    state = RunState.FAILED if exit_status else RunState.CERTIFIED
    return Found("", state, report, times)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold `folder` (made if needed) for one batch; the system frees it even if that is killed.

    Raises:
        UsageError: another batch holds it, or it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / LOCK, timeout=0)
        lock.acquire()
    except Timeout as error:
        raise UsageError(
            f"another batch is at work in {folder}; wait for its end, or choose another folder (-o)"
        ) from error
    except OSError as error:
        raise UsageError(f"cannot write into {folder}: {error.strerror or error}") from error
    try:
        yield
    finally:
        with suppress(OSError):
            lock.release()
