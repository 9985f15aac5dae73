"""What the commands share: options, and how a command's work ends in an exit status."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.console import Console, failure
from stplan.errors import UsageError

ScenePaths = Annotated[list[Path], typer.Argument(metavar="SCENE", help="Scene files (YAML).")]
Output = Annotated[
    Path,
    typer.Option("--output", "-o", metavar="DIR", help="Results go to DIR/NAME/."),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Override a value of the scene, as in solver.mu=0.1 or agents.sam.radius=0.4; may be repeated.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Say more.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]


def serve(quiet: bool, verbose: bool, as_json: bool, work: Callable[[Console], int]) -> None:
    """Do a command's work and leave with its exit status; no exception passes."""
    try:
        console = Console(quiet, verbose, as_json)
        status = work(console)
    except (Exception, KeyboardInterrupt) as error:
        status, messages = failure(error)
        console = Console(as_json=as_json)
        console.error(*messages)
        with suppress(UsageError):  # A full disk behind stdout: the messages above say enough.
            console.result_json({"exit_status": status, "messages": messages})
    raise typer.Exit(status)
