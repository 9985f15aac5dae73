"""The command that improves a finished run: improve."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.cli.scenes import read_scene
from stplan.cli.signals import answered_by
from stplan.errors import StoppedError
from stplan.stopping import StopRequest

app = group()


@command(app)
def improve(
    console: Console,
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run.")],
    *,
    budget: Annotated[
        str,
        typer.Option(
            metavar="BUDGET",
            help="A number of moves such as 200, repeatable, or of seconds such as 30s.",
        ),
    ] = "30s",
) -> int:
    """Improve a finished run, and write it anew.

    Other ways around each other are tried for a few agents at a time; a plan is kept where it is
    cheaper and certified, so the run never gets dearer. Its report tells how many moves were tried and
    accepted, and the cost before and after. Interrupted (Ctrl-C, SIGTERM) it writes the best so far.

    \b
    Examples:
      stplan improve outputs/cabin --budget 60s
      stplan improve outputs/cabin --budget 200
    """
    from stplan.files.atomic import write_set
    from stplan.files.run_folder import recorded_scene
    from stplan.improved_run import improve_run, read_run
    from stplan.improvement.budget import ImprovementBudget

    limits = ImprovementBudget.parse(budget)
    recorded = recorded_scene(run, "solve")
    finished = read_run(run, read_scene(recorded.source, recorded.overrides))
    stop = StopRequest()
    with answered_by(stop.make):
        with console.live_line() as live:
            improved = improve_run(
                finished, limits, progress=console.progress, stop=stop, live=live
            )
        with stop.held():
            files = write_set(run, improved.files)
    status = StoppedError.exit_status if improved.improvement.interrupted else 0
    record = improved.improvement.record
    console.result(
        f"{finished.scene.name}: {improved.status}",
        f"  {improved.certificate.summary}",
        f"  {record.sentence}",
    )
    console.result_json(
        {
            "exit_status": status,
            "status": improved.status,
            "improvement": record.as_dict(),
            "files": [str(path) for path in files],
        }
    )
    return status
