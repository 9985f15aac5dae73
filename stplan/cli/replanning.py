"""The command that goes on with a run when the world has changed: replan."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.cli.options import Happening, Output
from stplan.cli.signals import answered_by
from stplan.errors import SeedingError, StoppedError, UsageError
from stplan.stopping import StopRequest

if TYPE_CHECKING:
    from stplan.replanned_run import Continuation

app = group()


@command(app)
def replan(
    console: Console,
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run.")],
    *,
    at: Annotated[float | None, typer.Option(help="When --set becomes known, s.")] = None,
    settings: Happening = None,
    events: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Events as in a scene (YAML).")
    ] = None,
    output: Output = Path("outputs"),
) -> int:
    """Go on with a run whose world has changed, and write past and future as one run.

    What happened before is kept to the byte. From then on everybody goes on from its place and velocity;
    those whom the change concerns, and those in their way, are planned anew, and the whole is certified.
    Where there is no way to go on nothing is written, the exit status is 3, and it is said whether what is
    left of the old plan stays clear.

    \b
    Examples:
      stplan replan outputs/crossing --at 4 --set agents.ann.goal=[0,3] -o mended
      stplan replan outputs/crossing --events events.yaml -o mended
    """
    from stplan.planned import write_plan
    from stplan.replanned_run import events_of, open_continuation, set_event

    happening = [] if events is None else events_of(events)
    if settings:
        if at is not None and not math.isfinite(at):
            raise UsageError(f"--at is {at}; a time in s is expected")
        if at is None:
            raise UsageError("--set needs to know from when on: --at T")
        happening.append(set_event(at, settings))
    elif at is not None:
        raise UsageError("--at is the time of --set, and there is none")
    if not happening:
        raise UsageError("nothing happens; expected --at T --set KEY=VALUE, or --events FILE")
    before = open_continuation(run, happening)
    stop = StopRequest()
    with answered_by(stop.make):
        try:
            planned = before.replanned(progress=console.progress, stop=stop)
        except SeedingError:
            console.error(_of_rest(before))
            raise
        with stop.held():
            files = write_plan(planned, output / before.scene.name)
    status = StoppedError.exit_status if stop.made else planned.exit_status
    console.result(
        f"{before.scene.name}: {planned.status}",
        f"  {planned.certificate.summary}",
        *(f"  {one}" for one in planned.certificate.eased),
        f"  {output / before.scene.name}",
    )
    console.result_json(
        {
            "exit_status": status,
            "status": planned.status,
            "folder": str(output / before.scene.name),
            "files": [str(path) for path in files],
            "report": planned.report.as_dict(),
        }
    )
    return status


def _of_rest(before: Continuation) -> str:
    """What is left of the old plan, in a sentence."""
    rest, at = before.rest(), before.changes[0].at
    if rest is None:
        return f"nothing is left of the old plan after {at:g} s"
    if rest.holds:
        spot = "nothing interacts" if rest.smallest is None else f"tightest {rest.smallest}"
        return f"the old plan stays clear after {at:g} s if everybody goes on as before: {spot}"
    return f"the old plan does not stay clear after {at:g} s: {rest.violations[0]}"
