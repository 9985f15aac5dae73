"""The command line: arguments, help, signals, exit statuses. What the commands do is `commands`."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from stplan.cli import batch, bench, viewing
from stplan.cli.commands import (
    check_trajectories,
    compare,
    explain,
    plan_scenes,
    print_schema,
    validate_scenes,
)
from stplan.cli.console import write
from stplan.cli.options import Json, Output, Overrides, Quiet, ScenePaths, Verbose, serve

_HELP = """Plan collision-free space-time trajectories for many unequal agents in tight spaces.

A scene file (YAML) says where the walls are, who moves from where to where, how large, heavy and
patient everybody is. `solve` plans it and writes trajectories, a certificate that nobody touches
anybody or a wall at any instant, and a report. Results go to stdout and files, progress and
messages to stderr. `stplan COMMAND --help` has the details and examples of a command.
"""
_EPILOG = """\b
Examples:
  stplan solve scenes/bottleneck/bottleneck.yaml     plan; the files are in outputs/bottleneck/
  stplan explain outputs/bottleneck                  what is tight, who waits for whom
  stplan check outputs/bottleneck                    certify once more
  stplan diff golden outputs --atol 1e-6             compare with runs kept earlier
\b
Files of a run, in outputs/NAME/:
  trajectories.csv, .npz   agent, knot, x, y, t: straight at constant speed between knots
  seed.csv, .npz           the initial curves
  report.json              status, certificate, costs, arrival times; the same bytes every time
  run.json                 what differs from run to run: times, host, dates
\b
Exit status:
  0    done, and every trajectory written holds its certificate
  1    diff found a difference; check or explain found a violation
  2    the command line or a scene is wrong
  3    no collision-free initial curves were found
  4    the solver failed; the best feasible trajectories were still written; or memory ran out
  5    internal error
  130  interrupted; the best feasible trajectories so far were written

Units are metres, seconds and kilograms. The keys of a scene are in docs/scene-format.md.
`stplan --install-completion` teaches the shell to complete commands and options.
"""

app = typer.Typer(
    name="stplan",
    help=_HELP,
    epilog=_EPILOG,
    no_args_is_help=True,
    # Plain help and errors: they are read in logs and through pipes as often as in a terminal.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class Format(StrEnum):
    """How a result is written; `--json` is short for JSON."""

    TEXT = "text"
    JSON = "json"
    MARKDOWN = "markdown"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit status."""
    signal.signal(signal.SIGTERM, _interrupt)
    for stream in (sys.stdout, sys.stderr):
        # A terminal that lacks a letter of some agent's name shows its code.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    app(args=None if arguments is None else list(arguments), prog_name="stplan")


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        write(sys.stdout, f"stplan {version('stplan')}\n")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    del version


@app.command()
def solve(
    scenes: ScenePaths,
    *,
    output: Output = Path("outputs"),
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Plan scenes; write their trajectories and a report.

    For every scene initial curves are found that are clear of each other and of the walls, then all
    are made smooth and cheap at once, and the result is certified by code of its own. Interrupted
    (Ctrl-C, SIGTERM) it writes the best feasible trajectories so far. The same scene gives the same
    bytes, run.json excepted.

    Of several scenes each is planned; the exit status is the worst of them, in the order
    5, 130, 2, 3, 4, 0.

    \b
    Examples:
      stplan solve scenes/bottleneck/bottleneck.yaml
      stplan solve scene.yaml -o results --set solver.outer_iterations=8
      stplan solve scenes/*/*.yaml --quiet
    """
    serve(
        quiet, verbose, as_json,
        lambda console: plan_scenes(console, scenes, output, overrides or [], seed_only=False),
    )  # fmt: skip


@app.command()
def seed(
    scenes: ScenePaths,
    *,
    output: Output = Path("outputs"),
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Find only the initial curves.

    Writes seed.csv and seed.npz: curves that are clear, but neither smooth nor cheap. Exit status 3
    where none are found; `stplan explain SCENE` then says more.

    \b
    Example:
      stplan seed scenes/bottleneck/bottleneck.yaml --set seeding.rng_seed=3
    """
    serve(
        quiet, verbose, as_json,
        lambda console: plan_scenes(console, scenes, output, overrides or [], seed_only=True),
    )  # fmt: skip


@app.command()
def check(
    run_or_scene: Annotated[
        Path, typer.Argument(metavar="RUN_OR_SCENE", help="Folder of a run, or a scene file.")
    ],
    trajectories: Annotated[
        Path | None,
        typer.Argument(metavar="TRAJECTORIES", help="A .csv, a .npz or the folder of a run."),
    ] = None,
    *,
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Certify trajectories against a scene.

    In continuous time, and whoever wrote them: a .csv, a .npz or the folder of a run.
    Exit status 0 when the certificate holds, 1 when it is broken.

    \b
    Examples:
      stplan check outputs/bottleneck
      stplan check scenes/bottleneck/bottleneck.yaml outputs/bottleneck/seed.csv
    """
    serve(
        quiet, verbose, as_json,
        lambda console: check_trajectories(console, run_or_scene, trajectories, overrides or []),
    )  # fmt: skip


@app.command()
def diff(
    a: Annotated[
        Path,
        typer.Argument(metavar="A", help="A .csv, a .npz, a run's folder or a folder of runs."),
    ],
    b: Annotated[Path, typer.Argument(metavar="B", help="What to compare with A.")],
    *,
    atol: Annotated[float, typer.Option(help="Absolute tolerance, in m and in s.")] = 1e-9,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 0.0,
    output_format: Annotated[
        Format | None,
        typer.Option("--format", help="How to say it.  [default: text]", show_default=False),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Compare two runs, or two folders of runs; for CI.

    Says which agent differs most, by how much, at which knot and when; which agents, and of two
    folders which runs, are only in one of them; and, where both have a report.json, whether the
    certificate changed. A is what is expected. Two knots agree when they are at most
    ATOL + RTOL * size apart, size being their distance to the origin (or their time).
    Exit status 0 when all is equal within the tolerances, 1 when something differs.

    \b
    Examples:
      stplan diff outputs/bottleneck expected/trajectories.csv --atol 1e-6
      stplan diff golden outputs --atol 1e-6 --format markdown >> "$GITHUB_STEP_SUMMARY"
    """
    serve(
        quiet, verbose, as_json or output_format == Format.JSON,
        lambda console: compare(
            console, a, b, atol, rtol,
            markdown=not as_json and output_format == Format.MARKDOWN,
        ),
    )  # fmt: skip


@app.command("explain")
def explain_command(
    run_or_scene: Annotated[
        Path, typer.Argument(metavar="RUN_OR_SCENE", help="Folder of a run, or a scene file.")
    ],
    trajectories: Annotated[
        Path | None,
        typer.Argument(metavar="TRAJECTORIES", help="A .csv, a .npz or the folder of a run."),
    ] = None,
    *,
    everything: Annotated[
        bool, typer.Option("--all", help="Everything, not only the most important.")
    ] = False,
    time_limit: Annotated[
        float,
        typer.Option(help="Of a scene: longest search for initial curves, s; 0 leaves it out."),
    ] = 10.0,
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Say in words what is tight, who waits for whom, and why.

    Of a run, or of any trajectories against a scene: the pairs and walls that leave least room, who
    waits for whom, who is late, and who goes how much further than alone. Of a scene by itself:
    which places are narrow for which radii, who would meet whom, and whether initial curves are
    found; if not, whom that concerns, where and when.
    Exit status 0; 1 where the certificate is broken, 3 where no initial curves were found.

    \b
    Examples:
      stplan explain outputs/bottleneck
      stplan explain scenes/tight/cabin.yaml --all
      stplan explain scenes/bottleneck/bottleneck.yaml outputs/bottleneck/seed.csv --json
    """
    serve(
        quiet, verbose, as_json,
        lambda console: explain(
            console, run_or_scene, trajectories, overrides or [], time_limit,
            everything=everything,
        ),
    )  # fmt: skip


@app.command()
def validate(
    scenes: ScenePaths,
    *,
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Check scenes and their maps without planning.

    All faults are named at once, each as FILE:LINE:COLUMN: path: what is wrong, what is expected.
    Exit status 0 when every scene is valid, 2 otherwise.

    \b
    Example:
      stplan validate scenes/*/*.yaml
    """
    serve(
        quiet, verbose, as_json, lambda console: validate_scenes(console, scenes, overrides or [])
    )


@app.command()
def schema() -> None:
    """Print the JSON Schema of scene files.

    It is made from the model that validates scenes. Editors complete and check scene files with it,
    for example by a first line `# yaml-language-server: $schema=stplan.schema.json`.

    \b
    Example:
      stplan schema > stplan.schema.json
    """
    serve(False, False, True, print_schema)


def _interrupt(number: int, frame: FrameType | None) -> None:
    del number, frame
    raise KeyboardInterrupt


app.add_typer(viewing.app)
app.add_typer(batch.app)
app.add_typer(bench.app)
