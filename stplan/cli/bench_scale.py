"""The command that measures many agents."""

from __future__ import annotations

from typing import Annotated

import typer

from stplan.cli.bench import FOLDER, NO_JSON, Full, Output, benchmarks, finish, names_in
from stplan.cli.bench_crowds import app
from stplan.cli.command import command
from stplan.cli.console import Console
from stplan.cli.cores import usable_cores
from stplan.errors import UsageError

__all__ = ["app", "scale"]


@command(benchmarks, without=NO_JSON)
def scale(
    console: Console,
    *,
    output: Output = FOLDER,
    families: Annotated[str, typer.Option(metavar="A,B", help="Only scenes that begin so.")] = "",
    largest: Annotated[
        int, typer.Option(min=1, metavar="N", help="Leave out scenes of more agents.")
    ] = 10000,
    full: Full = False,
) -> int:
    """Whole plans of up to 10,000 agents: time, memory, and what a cluster would take.

    Every scene is planned by one process and on all cores. Writes scale.csv, scale.md and figures of time
    and memory over agents. Plans of open fields are taken apart into what one process does and what many
    share, and that is carried on to 100,000 agents.

    \b
    Examples:
      stplan bench scale
      stplan bench scale --full --families open,crossing --largest 1000
    """
    from stplan.bench import scale, scale_table
    from stplan.bench.plots import require_matplotlib

    require_matplotlib()
    begins = tuple(names_in(families)) or ("",)
    chosen = [
        case for case in scale.cases() if (full or case.small) and case.family.startswith(begins)
    ]
    if not chosen:
        raise UsageError(f"--families {families}: no such scenes")
    measured = scale.measure(
        chosen, largest=largest, workers=usable_cores(), progress=console.progress
    )
    return finish(console, output, scale_table.files(measured, scale.clusters(measured)))
