"""The commands that show runs: plot, animate, view, export. Arguments and help only."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stplan.cli.options import Json, Quiet, Verbose, serve
from stplan.cli.viewing_commands import animate_runs, export_run, plot_run, view_run

app = typer.Typer(rich_markup_mode=None)

RunPath = Annotated[
    Path, typer.Argument(metavar="RUN", help="Folder of a run, or a .npz or .csv in it.")
]
Picture = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="The file to write.", show_default=False),
]
SceneOfRun = Annotated[
    Path | None,
    typer.Option("--scene", metavar="SCENE", help="The scene, where the run's own is lost."),
]


@app.command()
def plot(
    run: RunPath,
    *,
    output: Picture = None,
    show: Annotated[
        str, typer.Option(metavar="PART,...", help="Any of map, time and rods.")
    ] = "map,time,rods",
    seed: Annotated[bool, typer.Option("--seed", help="Draw the initial curves too.")] = False,
    dpi: Annotated[float, typer.Option(help="Pixels an inch.")] = 150.0,
    scene: SceneOfRun = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Draw a run.

    Its map, clearance and speed over time, and its rods in space and time. PNG, SVG or PDF by the
    name of FILE; RUN/plot.png unless told.

    \b
    Examples:
      stplan plot outputs/bottleneck
      stplan plot outputs/bottleneck --seed --show map -o bottleneck.svg
    """
    serve(
        quiet, verbose, as_json,
        lambda console: plot_run(
            console, run, output, scene, show.split(","), seed=seed, dpi=dpi
        ),
    )  # fmt: skip


@app.command()
def animate(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN...", help="Folders of runs, or .npz or .csv files in them."),
    ],
    *,
    output: Picture = None,
    fps: Annotated[float, typer.Option(help="Frames a second.")] = 25.0,
    speed: Annotated[
        float | None,
        typer.Option(
            help="Seconds of the run in a second.  [default: 1, or as much as makes 12 s]"
        ),
    ] = None,
    size: Annotated[
        str, typer.Option(metavar="WIDTH[xHEIGHT]", help="Pixels; the height follows the map.")
    ] = "960",
    scene: SceneOfRun = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Make a movie of a run, or of several side by side.

    MP4, GIF or WebP by the name of FILE; RUN/movie.mp4 unless told.

    \b
    Examples:
      stplan animate outputs/bottleneck
      stplan animate outputs/bottleneck/seed.npz outputs/bottleneck -o both.webp
      stplan animate outputs/bottleneck --speed 2 --fps 20 --size 1280x720 -o talk.gif
    """
    serve(
        quiet, verbose, as_json,
        lambda console: animate_runs(
            console, runs, output, scene, fps=fps, speed=speed, size=size
        ),
    )  # fmt: skip


@app.command()
def view(
    run: RunPath,
    *,
    output: Picture = None,
    scene: SceneOfRun = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Write an interactive page of a run.

    One HTML file that needs no network: the map with playback, the rods in space and time, every
    agent's numbers and the tightest moments. RUN/view.html unless told.

    \b
    Example:
      stplan view outputs/bottleneck
    """
    serve(quiet, verbose, as_json, lambda console: view_run(console, run, output, scene))


@app.command()
def export(
    run: RunPath,
    *,
    form: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="glb or jupedsim.")
    ] = "glb",
    output: Picture = None,
    fps: Annotated[float, typer.Option(help="Frames a second in trajectory text.")] = 25.0,
    pace: Annotated[
        float | None,
        typer.Option(help="Height of a second in a GLB, m.  [default: the scene's time_scale]"),
    ] = None,
    scene: SceneOfRun = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Json = False,
) -> None:
    """Write a run for other programs.

    glb: rods and walls for Blender and other 3D programs. jupedsim: trajectory text for PedPy and
    JuPedSim. RUN/rods.glb or RUN/jupedsim.txt unless told.

    \b
    Examples:
      stplan export outputs/bottleneck
      stplan export outputs/bottleneck --format jupedsim --fps 10 -o bottleneck.txt
    """
    serve(
        quiet, verbose, as_json,
        lambda console: export_run(console, run, output, scene, form=form, fps=fps, pace=pace),
    )  # fmt: skip
