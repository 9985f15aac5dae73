"""A batch from its first run to its summary: skip what is done, plan the rest, write, sum up."""

from __future__ import annotations

import json
from collections.abc import Generator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from stplan.batch.events import GO_ON, Event, Finished, Progress, Started, Stop
from stplan.batch.folder import found, locked
from stplan.batch.outcome import Outcome, RunState
from stplan.batch.result import Batch, Result
from stplan.batch.runs import Run
from stplan.batch.summary import SUMMARIES, write_summary
from stplan.errors import UsageError
from stplan.files.atomic import remove_unfinished, write_atomically, write_set
from stplan.files.recorded import REPORT, RUN_RECORD, parse_report, parse_times

TRACEBACK = "traceback.txt"


@dataclass(frozen=True)
class Settings:
    """How a batch is run.

    Attributes:
        output: its folder; a run writes into output/NAME/.
        jobs: processes at a time.
        timeout: seconds for a run, or None.
        retries: how often a run is begun again whose worker died.
        fail_fast: stop at the first run that is not certified.
        force: plan again what is done.
        dask: address of a scheduler, "local" for one of our own, or None for plain processes.
    """

    output: Path
    jobs: int
    timeout: float | None = None
    retries: int = 1
    fail_fast: bool = False
    force: bool = False
    dask: str | None = None


class Watcher(Protocol):
    """Someone who looks on."""

    def begin(self, total: int) -> None:
        """The batch has so many runs."""

    def started(self, run: str) -> None:
        """A run has begun."""

    def progress(self, run: str, line: str) -> None:
        """A run says how far it is."""

    def finished(self, result: Result) -> None:
        """A run is over and its files are written, or it was found done."""


def run_batch(
    runs: Sequence[Run], settings: Settings, watcher: Watcher, stop: Stop | None = None
) -> Batch:
    """Bring every run to its end and write the summaries.

    Asked to `stop`, the batch ends politely: the runs at work give their best so far, the others
    are "not run". Asked again, it ends at once. Whatever happens, files that were written are
    whole, and the same call goes on from there.

    Raises:
        UsageError: the folder cannot be written, or no worker can be had.
    """
    stop = stop or Stop()
    with locked(settings.output):
        results: dict[str, Result] = {}
        _clean(settings.output)
        watcher.begin(len(runs))
        _go_through(runs, settings, stop, watcher, results)
        ordered = [
            results.get(run.name) or Result(run, settings.output / run.name, RunState.NOT_RUN)
            for run in runs
        ]
        batch = Batch(tuple(ordered), interrupted=stop.asked)
        write_summary(settings.output, batch)
    return batch


def _clean(output: Path) -> None:
    try:
        for name in SUMMARIES:  # Until this batch ends, they would tell of another one.
            (output / name).unlink(missing_ok=True)
        remove_unfinished(output)
    except OSError as error:
        raise UsageError(f"cannot write into {output}: {error.strerror or error}") from error


def _go_through(
    runs: Sequence[Run],
    settings: Settings,
    stop: Stop,
    watcher: Watcher,
    results: dict[str, Result],
) -> None:
    """Fill `results` with what comes of each run that is begun."""

    def end(result: Result) -> bool:
        """Note a result; True where the batch ends with it."""
        results[result.run.name] = result
        watcher.finished(result)
        return settings.fail_fast and result.exit_status != 0

    waiting = []
    for run in runs:
        if stop.asked:
            return
        result = _without_planning(run, settings)
        if result is None:
            waiting.append(run)
        elif end(result):
            return
    by_name = {run.name: run for run in waiting}
    with closing(_execution(waiting, settings, stop)) as events:
        for event in events:
            match event:
                case Started(name):
                    watcher.started(name)
                case Progress(name, line):
                    watcher.progress(name, line)
                case Finished(name, outcome):
                    if end(_written(by_name[name], settings.output / name, outcome)):
                        return


def _without_planning(run: Run, settings: Settings) -> Result | None:
    """The result of a run that needs no planning, or must not have any."""
    folder = settings.output / run.name
    if run.refusal:
        return Result(run, folder, RunState.REFUSED, run.refusal)
    if settings.force:
        return None
    there = found(run, folder)
    if there.missing:
        return None
    advice = there.report.advice
    return Result(
        run, folder, there.state, (advice,) if advice else (), there.report, there.times,
        there.times.total, fresh=False,
    )  # fmt: skip


def _execution(runs: Sequence[Run], settings: Settings, stop: Stop) -> Generator[Event, None, None]:
    if settings.dask is None:
        from stplan.batch.processes import run_in_processes

        return run_in_processes(
            runs, jobs=settings.jobs, timeout=settings.timeout, retries=settings.retries, stop=stop
        )
    from stplan.batch.cluster import run_on_cluster

    return run_on_cluster(
        runs, settings.dask, jobs=settings.jobs, timeout=settings.timeout,
        retries=settings.retries, stop=stop,
    )  # fmt: skip


def _written(run: Run, folder: Path, outcome: Outcome) -> Result:
    """Write what a run gave; its result."""
    messages = outcome.messages
    if outcome.traceback:
        path = write_atomically(folder / TRACEBACK, outcome.traceback.encode(errors="replace"))
        messages = (f"{messages[0]}; traceback saved to {path}", *messages[1:])
    if not outcome.files:
        return Result(run, folder, outcome.state, messages, seconds=outcome.seconds)
    with suppress(OSError):
        remove_unfinished(folder)
        (folder / TRACEBACK).unlink(missing_ok=True)
    try:
        write_set(folder, outcome.files)
    except UsageError as error:
        # Every other run would be planned in vain.
        raise UsageError(f"{error}; {GO_ON}") from error
    report = parse_report(json.loads(outcome.files[REPORT]), folder / REPORT)
    times = parse_times(json.loads(outcome.files[RUN_RECORD]), folder / RUN_RECORD)
    return Result(run, folder, outcome.state, messages, report, times, times.total)
