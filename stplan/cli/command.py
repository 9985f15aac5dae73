"""How a function becomes a command: its options, the console it speaks through, its exit status.

A command is one function of a module listed in `app`: it takes a `Console`, then its arguments, annotated
as typer reads them, and returns its exit status; its docstring is its help.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from typing import Annotated, Any, cast

import typer

from stplan.callbacks import COMPILING
from stplan.cli.console import Console, failure, further_reading
from stplan.errors import UsageError

Work = Callable[..., int]

_SWITCHES = {
    "quiet": Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.")],
    "verbose": Annotated[bool, typer.Option("--verbose", "-v", help="Say more.")],
    "as_json": Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")],
}


def group(**settings: Any) -> typer.Typer:
    """A group of commands, with plain help: it is read in logs and pipes as often as in a terminal."""
    return typer.Typer(rich_markup_mode=None, **settings)


def command(
    app: typer.Typer, name: str | None = None, *, without: tuple[str, ...] = ()
) -> Callable[[Work], Work]:
    """Add the decorated function to `app` as a command.

    Args:
        name: of the command, where it is not the function's.
        without: those of the switches --quiet, --verbose and --json ("as_json") that it does not have.
    """
    switches = {key: switch for key, switch in _SWITCHES.items() if key not in without}

    def register(work: Work) -> Work:
        app.command(name)(_entry(work, switches))
        return work

    return register


def _entry(work: Work, switches: dict[str, Any]) -> Callable[..., None]:
    """`work` as typer calls it: its own arguments and the switches, and no result but the exit."""
    _, *own = inspect.signature(work, eval_str=True).parameters.values()
    shared = [
        inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=switch)
        for key, switch in switches.items()
    ]
    parameters = [*own, *shared]

    @wraps(work)
    def entry(**arguments: Any) -> None:
        chosen = {key: arguments.pop(key) for key in switches}
        raise typer.Exit(exit_status(lambda console: work(console, **arguments), **chosen))

    described = cast(Any, entry)
    described.__signature__ = inspect.Signature(parameters)
    described.__annotations__ = {each.name: each.annotation for each in parameters}
    return entry


def exit_status(work: Work, **switches: bool) -> int:
    """Do a command's work with a console; its exit status. No exception passes."""
    console = Console(as_json=switches.get("as_json", False))
    try:
        console = Console(**switches)
        token = COMPILING.set(console.compiling)
        try:
            return work(console)
        finally:
            COMPILING.reset(token)
    except (Exception, KeyboardInterrupt) as error:
        status, messages = failure(error)
        console.error(*messages)
        for line in further_reading(error):
            console.hint(line)
        with suppress(UsageError):  # A full disk behind stdout: the messages above say enough.
            console.result_json({"exit_status": status, "messages": messages})
        return status
