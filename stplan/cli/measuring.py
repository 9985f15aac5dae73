"""The command that measures runs as crowds are measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.cli.viewing import RunPath, SceneOfRun, beside, check_positive, open_views

app = group()


@command(app)
def measure(
    console: Console,
    run: RunPath,
    *,
    line: Annotated[
        list[str] | None,
        typer.Option(metavar="X1,Y1,X2,Y2", help="A line that is crossed, m; again and again."),
    ] = None,
    area: Annotated[
        list[str] | None,
        typer.Option(metavar="X,Y,X,Y[,...]", help="A rectangle or polygon, m; again and again."),
    ] = None,
    dt: Annotated[float, typer.Option("--dt", help="Seconds between samples.")] = 0.1,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FOLDER", help="[default: RUN/measure]"),
    ] = None,
    scene: SceneOfRun = None,
) -> int:
    """Measure flow and density of a run with PedPy.

    The evacuation curve (who has arrived when), crossings and flow at lines, density and speed in areas and
    the fundamental diagram, as CSV tables and pictures. Without --line and --area the places of the scene are
    measured. Agents are points: headings and body ellipses are not modelled.

    \b
    Examples:
      stplan measure outputs/lecture-hall
      stplan measure outputs/bottleneck --line 5,-1,5,1 --area 2,-2,5,2
    """
    from stplan.optional import require

    require("pedpy", "stplan measure", extra="measure")
    require("matplotlib", "stplan measure", extra="measure")
    from stplan.exports.flow import flow_figures
    from stplan.exports.flow_tables import csv_files, sentences
    from stplan.exports.probes import probes_of
    from stplan.files.atomic import write_set
    from stplan.viewing.figure_flow import density_picture, diagram_picture, evacuation_picture

    check_positive("--dt", dt)
    (view,) = open_views(console, [run], scene)
    figures = flow_figures(view, tuple(probes_of(line or [], area or [], view.places)), dt)
    contents = csv_files(figures)
    contents["evacuation.png"] = evacuation_picture(
        figures.evacuation, [(one.probe.name, one.crossings) for one in figures.lines]
    )
    if figures.areas:
        tables = [(one.probe.name, one.rows) for one in figures.areas]
        contents["fundamental-diagram.png"] = diagram_picture(tables)
        contents["density.png"] = density_picture(tables)
    target = output or beside(run, "measure")
    files = write_set(target, contents)
    console.result(*sentences(figures), f"{target}: {' '.join(path.name for path in files)}")
    console.result_json(
        {
            "exit_status": 0,
            "folder": str(target),
            "files": [str(path) for path in files],
            "flows": {one.probe.name: one.mean_flow for one in figures.lines},
        }
    )
    return 0
