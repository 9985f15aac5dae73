"""The command that plans many scenes: arguments and help only."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.commands import run_batch
from stplan.cli.options import Json, Overrides, Quiet, Verbose, serve

app = typer.Typer(rich_markup_mode=None)


class OutputFormat(StrEnum):
    """What `batch` prints when it is over."""

    TEXT = "text"
    JSON = "json"
    JUNIT = "junit"
    GITHUB = "github"


@app.command()
def batch(
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
    sweeps: Annotated[
        list[str] | None,
        typer.Option(
            "--sweep",
            metavar="KEY=A,B,C",
            help="Run with each of the values; several sweeps: with every combination.",
        ),
    ] = None,
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
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
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
    serve(
        quiet, verbose, as_json or output_format is OutputFormat.JSON,
        lambda console: run_batch(
            console, scenes, output=output, overrides=overrides or [], sweeps=sweeps or [],
            filters=filters or [], jobs=jobs, timeout=timeout, retries=retries,
            fail_fast=fail_fast, force=force, dask=dask, dry_run=dry_run,
            output_format=output_format,
        ),
    )  # fmt: skip
