"""The command line as a whole: its help, its version, and the groups of commands it is made of."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from stplan.cli import (
    batch,
    bench_plans,
    checking,
    doctor,
    exporting,
    importing,
    improving,
    measuring,
    planning,
    replanning,
    scenes,
    viewing,
)
from stplan.cli.command import exit_status, group
from stplan.cli.console import Console, write
from stplan.cli.signals import interrupt_on_terminate
from stplan.errors import UsageError

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

# In the order in which help lists them.
GROUPS = (
    planning.app, improving.app, replanning.app, checking.app, scenes.app, importing.app, viewing.app,
    exporting.app, measuring.app, batch.app, bench_plans.app, doctor.app,
)  # fmt: skip

app = group(
    name="stplan",
    help=_HELP,
    epilog=_EPILOG,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for commands in GROUPS:
    app.add_typer(commands)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit status."""
    interrupt_on_terminate()
    for stream in (sys.stdout, sys.stderr):
        # A terminal that lacks a letter of some agent's name shows its code.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    app(args=None if arguments is None else list(arguments), prog_name="stplan")


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    *,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="With --version: of all libraries too, as JSON.")
    ] = False,
) -> None:
    if version:
        _print_version(as_json)
        raise typer.Exit
    if context.invoked_subcommand is None:
        raise typer.Exit(exit_status(_no_command))
    if as_json:
        raise typer.Exit(exit_status(_misplaced))


def _print_version(as_json: bool) -> None:
    if as_json:
        from stplan.files.json_file import json_bytes
        from stplan.installation.parts import program_versions

        write(sys.stdout, json_bytes(program_versions()).decode())
    else:
        from importlib.metadata import version

        write(sys.stdout, f"stplan {version('stplan')}\n")


def _no_command(console: Console) -> int:
    raise UsageError("a command is expected; stplan --help lists them")


def _misplaced(console: Console) -> int:
    raise UsageError("--json goes with --version, or behind the command: stplan COMMAND --json")
