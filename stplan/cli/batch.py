"""The command that plans many scenes."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console, worst, write
from stplan.cli.cores import usable_cores
from stplan.cli.options import Overrides, Sweeps
from stplan.cli.signals import answered_by
from stplan.errors import UsageError

if TYPE_CHECKING:
    from stplan.batch.campaign import Settings
    from stplan.batch.runs import Run

app = group()


class OutputFormat(StrEnum):
    """What `batch` prints when it is over."""

    TEXT = "text"
    JSON = "json"
    JUNIT = "junit"
    GITHUB = "github"


@command(app)
def batch(
    console: Console,
    scenes: Annotated[
        list[str],
        typer.Argument(metavar="SCENES", help="Scene files, folders of them, or glob patterns."),
    ],
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Results go to DIR/RUN/.")
    ] = Path("outputs"),
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", min=1, help="Processes at a time.  [default: all cores]"),
    ] = None,
    overrides: Overrides = None,
    sweeps: Sweeps = None,
    filters: Annotated[
        list[str] | None,
        typer.Option(
            "--filter",
            metavar="PATTERN",
            help="Only runs so named, as in 'circle-*'; may be repeated.",
        ),
    ] = None,
    timeout: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Stop a run after so long, with its best so far."),
    ] = None,
    retries: Annotated[
        int, typer.Option(min=0, help="Begin a run again so often if its worker dies.")
    ] = 1,
    fail_fast: Annotated[
        bool,
        typer.Option(
            "--fail-fast/--keep-going", help="End at the first run that is not certified, or go on."
        ),
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Plan again what is done.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say what would be planned, and why.")
    ] = False,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Run on this Dask cluster; 'local' starts one on this machine."
        ),
    ] = None,
    output_format: Annotated[
        OutputFormat, typer.Option("--output-format", help="What is printed on stdout at the end.")
    ] = OutputFormat.TEXT,
) -> int:
    """Plan many scenes in parallel, leaving out what is done.

    A run is done when its files are whole and were planned from the same scene, mesh and
    settings by the same version. Killed at any moment, the same command goes on from there.

    DIR/batch.csv and DIR/batch.json sum up. Exit status 0 only when every run is certified,
    else the worst of the runs, in the order 5, 130, 2, 3, 4.

    \b
    Examples:
      stplan batch scenes -o results --jobs 8
      stplan batch 'scenes/**/circle-*.yaml' --sweep seeding.rng_seed=0,1,2 --dry-run
      stplan batch scenes --timeout 300 --output-format junit > junit.xml
      stplan batch scenes --dask tcp://10.0.0.1:8786
    """
    console.as_json |= output_format is OutputFormat.JSON
    if timeout is not None and not (math.isfinite(timeout) and timeout > 0):
        raise UsageError(f"--timeout is {timeout}; expected a number of seconds above 0")
    from stplan.batch.campaign import Settings, run_batch
    from stplan.batch.events import Stop
    from stplan.batch.formats import github, junit
    from stplan.batch.runs import list_runs
    from stplan.batch.summary import SUMMARIES, summary
    from stplan.batch.watchers import LineWatcher, live_table

    runs = list_runs(
        scenes, output=output, overrides=overrides or [], sweeps=sweeps or [], filters=filters or []
    )
    settings = Settings(
        output,
        jobs or usable_cores(),
        timeout,
        retries,
        fail_fast=fail_fast,
        force=force,
        dask=dask,
    )
    if dry_run:
        return _preview(console, runs, settings)
    stop = Stop()
    with answered_by(stop.ask):
        if sys.stderr.isatty() and not (console.quiet or console.verbose):
            with live_table() as table:
                done = run_batch(runs, settings, table, stop)
            console.error(*(line for result in done.results for line in result.complaints))
        else:
            watcher = LineWatcher(console.progress, console.error, console.verbose)
            done = run_batch(runs, settings, watcher, stop)
    status = worst(done.exit_statuses)
    console.result_json({"exit_status": status, **summary(done)})
    if output_format == OutputFormat.JUNIT:
        write(sys.stdout, junit(done))
    elif output_format == OutputFormat.GITHUB:
        write(sys.stdout, github(done))
    else:
        console.result(done.sentence, f"  {output}{os.sep}: {' '.join(SUMMARIES)}")
    return status


def _preview(console: Console, runs: Sequence[Run], settings: Settings) -> int:
    """Say what a batch would do."""
    from stplan.batch.folder import found

    records: list[dict[str, Any]] = []
    for run in runs:
        what, why = "refused", "; ".join(run.refusal)
        if not run.refusal:
            why = "--force" if settings.force else found(run, settings.output / run.name).missing
            what = "plan" if why else "done"
        records.append(
            {
                "run": run.name, "scene": str(run.source), "overrides": list(run.overrides),
                "hash": run.content_hash or None, "action": what, "reason": why or None,
            }
        )  # fmt: skip
        console.result(f"{what:7}  {run.name}" + (f": {why}" if why else ""))
    status = 2 if any(run.refusal for run in runs) else 0
    console.result_json({"exit_status": status, "runs": records})
    return status
