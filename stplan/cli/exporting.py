"""The command that writes runs for other programs."""

from __future__ import annotations

from typing import Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.cli.viewing import (
    Picture,
    RunPath,
    SceneOfRun,
    beside,
    check_positive,
    open_views,
    written,
)
from stplan.errors import UsageError

app = group()


@command(app)
def export(
    console: Console,
    run: RunPath,
    *,
    form: Annotated[
        str,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="glb, animated-glb, csv, blender, jupedsim, jupedsim-sqlite, geojson, paths, splines, "
            "vda5050, openrmf, hdf5, parquet, mcap or usd.",
        ),
    ] = "glb",
    output: Picture = None,
    dt: Annotated[
        float | None,
        typer.Option("--dt", help="Seconds between samples.  [default: 0.1; of jupedsim 0.04]"),
    ] = None,
    fps: Annotated[float | None, typer.Option(help="Samples a second, instead of --dt.")] = None,
    smoothing: Annotated[
        float, typer.Option(help="Seconds over which headings follow motion.")
    ] = 0.5,
    pace: Annotated[
        float | None,
        typer.Option(help="Height of a second in a GLB, m.  [default: the scene's time_scale]"),
    ] = None,
    scene: SceneOfRun = None,
) -> int:
    """Write a run for other programs.

    glb holds rods in space and time and the walls, animated-glb moving discs; csv, blender, jupedsim (text
    for PedPy and JuPedSim), jupedsim-sqlite, vda5050, openrmf, hdf5, parquet, mcap (ROS 2, Foxglove) and
    usd the run at fixed steps; geojson and paths the knots as planned; splines smooth curves through the
    knots, certified anew. docs/formats.md says more. The file
    goes into the run's folder unless told.

    \b
    Examples:
      stplan export outputs/bottleneck
      stplan export outputs/bottleneck --format jupedsim --fps 10 -o bottleneck.txt
      stplan export outputs/bottleneck --format csv --dt 0.1
    """
    from stplan.exports.registry import EXPORTS
    from stplan.exports.settings import STEP, ExportSettings

    if form not in EXPORTS:
        raise UsageError(f"--format: {form!r} is none of {', '.join(EXPORTS)}")
    if (dt is not None or fps is not None) and not EXPORTS[form].sampled:
        raise UsageError(f"--format {form} holds the run as planned, without --dt or --fps")
    if dt is not None and fps is not None:
        raise UsageError("--dt and --fps say the same; one of them is expected")
    for name, value in (("--fps", fps), ("--dt", dt), ("--smoothing", smoothing), ("--pace", pace)):
        if value is not None:
            check_positive(name, value)
    step = (
        dt
        if dt is not None
        else 1.0 / fps
        if fps is not None
        else 0.04
        if form == "jupedsim"
        else STEP
    )
    target = output or beside(run, EXPORTS[form].file)
    (view,) = open_views(console, [run], scene)
    return written(
        console, target, EXPORTS[form].write(view, ExportSettings(step, smoothing, pace))
    )
