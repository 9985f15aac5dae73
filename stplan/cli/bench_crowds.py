"""The command that measures crowds."""

from __future__ import annotations

from typing import Annotated

import typer

from stplan.cli.bench import FOLDER, NO_JSON, Full, Output, benchmarks, finish, names_in
from stplan.cli.bench_maps import app
from stplan.cli.command import command
from stplan.cli.console import Console

__all__ = ["app", "crowds"]


@command(benchmarks, without=NO_JSON)
def crowds(
    console: Console,
    *,
    output: Output = FOLDER,
    families: Annotated[str, typer.Option(metavar="A,B", help="Only families that begin so.")] = "",
    draws: Annotated[
        int | None, typer.Option(min=1, help="Scenes of a case.  [default: 2; 20 with --full]")
    ] = None,
    largest: Annotated[
        int, typer.Option(min=1, metavar="N", help="Leave out cases of more agents.")
    ] = 1000,
    full: Full = False,
) -> int:
    """Crowds that leave rooms, pass and exchange, planned whole.

    Writes crowds.csv, a row a draw, and crowds.md, a row a case: how many plans hold their certificates,
    processor time beside what is asked, and how long ways are where points are assigned.

    \b
    Examples:
      stplan bench crowds
      stplan bench crowds --families grid,counterflow --draws 3 --largest 100
    """
    from stplan.bench import crowds, crowds_table

    measured = crowds.measure(
        crowds.chosen_cases(names_in(families), full=full),
        draws or (crowds.FULL_DRAWS if full else crowds.SMALL_DRAWS),
        largest=largest,
        progress=console.progress,
    )
    return finish(console, output, crowds_table.files(measured))
