"""Arguments and options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

ScenePaths = Annotated[
    list[Path], typer.Argument(metavar="SCENE", help="Scene files (YAML); - is stdin.")
]
RunOrScene = Annotated[
    Path, typer.Argument(metavar="RUN_OR_SCENE", help="Folder of a run, or a scene file.")
]
Trajectories = Annotated[
    Path | None,
    typer.Argument(metavar="TRAJECTORIES", help="A .csv, a .npz or the folder of a run."),
]
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
Happening = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="A value of the scene from then on, as in agents.sam.goal=[2,3]; may be repeated.",
    ),
]
Sweeps = Annotated[
    list[str] | None,
    typer.Option(
        "--sweep",
        metavar="KEY=A,B,C",
        help="Run with each of the values; several sweeps: with every combination.",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        metavar="N",
        min=1,
        help="Processes that optimise blocks of many agents at the same time.  [default: all cores]",
    ),
]
Cluster = Annotated[
    str | None,
    typer.Option(
        "--dask",
        metavar="ADDRESS",
        help="Optimise blocks of many agents on this Dask cluster; 'local' starts one here.",
    ),
]
Budget = Annotated[
    str | None,
    typer.Option(
        "--improve",
        metavar="BUDGET",
        help="Then improve the plan: a number of moves such as 200, repeatable, or of seconds such as 30s.",
    ),
]
