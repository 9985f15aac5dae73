"""The commands that show runs: plot, animate and view."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.errors import UsageError

if TYPE_CHECKING:
    from stplan.viewing.run_view import RunView

app = group()

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


@command(app)
def plot(
    console: Console,
    run: RunPath,
    *,
    output: Picture = None,
    show: Annotated[
        str, typer.Option(metavar="PART,...", help="Any of map, time and rods.")
    ] = "map,time,rods",
    seed: Annotated[bool, typer.Option("--seed", help="Draw the initial curves too.")] = False,
    dpi: Annotated[float, typer.Option(help="Pixels an inch.")] = 150.0,
    scene: SceneOfRun = None,
) -> int:
    """Draw a run.

    Its map, clearance and speed over time, and its rods in space and time. PNG, SVG or PDF by the
    name of FILE; RUN/plot.png unless told.

    \b
    Examples:
      stplan plot outputs/bottleneck
      stplan plot outputs/bottleneck --seed --show map -o bottleneck.svg
    """
    from stplan.optional import require

    require("matplotlib", "stplan plot")
    from stplan.viewing.figure import FORMATS, PARTS, figure_bytes

    parts = show.split(",")
    unknown = [part for part in parts if part not in PARTS]
    if unknown:
        raise UsageError(f"--show: {unknown[0]!r} is none of {', '.join(PARTS)}")
    check_positive("--dpi", dpi, most=1200)
    target = output or beside(run, "plot.png")
    kind = _kind(target, FORMATS)
    (view,) = open_views(console, [run], scene)
    if seed and view.seed is None:
        console.progress(f"note: {run} holds no initial curves to draw behind its trajectories")
    content = figure_bytes(view, kind, parts=tuple(parts), seed=seed, dpi=dpi)
    return written(console, target, content)


@command(app)
def animate(
    console: Console,
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
) -> int:
    """Make a movie of a run, or of several side by side.

    MP4, GIF or WebP by the name of FILE; RUN/movie.mp4 unless told.

    \b
    Examples:
      stplan animate outputs/bottleneck
      stplan animate outputs/bottleneck/seed.npz outputs/bottleneck -o both.webp
      stplan animate outputs/bottleneck --speed 2 --fps 20 --size 1280x720 -o talk.gif
    """
    from stplan.optional import require

    require("matplotlib", "stplan animate")
    from stplan.viewing.movie import FORMATS, movie_bytes

    check_positive("--fps", fps)
    if speed is not None:
        check_positive("--speed", speed)
    pixels = _size(size)
    target = output or beside(runs[0], "movie.mp4")
    kind = _kind(target, FORMATS)
    if kind == "mp4":
        require("imageio_ffmpeg", "an MP4 movie")
    views = open_views(console, runs, scene)
    titles = [view.title for view in views]
    if len(set(titles)) < len(titles):
        titles = [str(run) for run in runs]
    with console.live_line() as live:
        content = movie_bytes(
            views, titles, kind, fps=fps, speed=speed, size=pixels,
            progress=lambda line: live(lambda: line) if live else None,
        )  # fmt: skip
    return written(console, target, content)


@command(app)
def view(
    console: Console,
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN...", help="Folder of a run, or a .npz or .csv in it; one or two."
        ),
    ],
    *,
    output: Picture = None,
    scene: SceneOfRun = None,
) -> int:
    """Write an interactive page of a run, or of two over each other.

    One HTML file that needs no network: the map with playback, the rods in space and time, every
    agent's numbers and the tightest moments. Of two runs the second is drawn as rings, in step with the
    first, and the page lists where they differ most. RUN/view.html unless told, of two RUN/view-both.html.

    \b
    Examples:
      stplan view outputs/bottleneck
      stplan view outputs/bottleneck outputs/bottleneck/seed.npz
    """
    from stplan.viewing.page import page_bytes

    if len(runs) > 2:
        raise UsageError(f"{len(runs)} runs are named; one is shown, or two over each other")
    target = output or beside(runs[0], "view.html" if len(runs) == 1 else "view-both.html")
    _kind(target, ("html",))
    view, *others = open_views(console, runs, scene)
    other = others[0] if others else None
    alike = other is not None and other.title == view.title
    titles = [str(run) for run in runs] if alike else []
    return written(console, target, page_bytes(view, other, titles))


def open_views(console: Console, runs: Sequence[Path], scene: Path | None) -> list[RunView]:
    """Runs as they are shown; what is missing of them is said."""
    from stplan.viewing.run_view import open_run

    views = [open_run(run, scene) for run in runs]
    for note in dict.fromkeys(note for view in views for note in view.notes):
        console.progress(f"note: {note}")
    return views


def beside(run: Path, name: str) -> Path:
    """Where a file goes unless told: into the run's folder; of initial curves by their name."""
    if run.is_dir():
        return run / name
    return run.parent / (f"seed-{name}" if run.stem == "seed" else name)


def _kind(target: Path, known: Sequence[str]) -> str:
    kind = target.suffix.lower().removeprefix(".")
    if kind not in known:
        raise UsageError(f"{target}: expected a name ending in .{', .'.join(known)}")
    return kind


def check_positive(option: str, value: float, most: float = math.inf) -> None:
    """Raise UsageError where the value of an option is not above 0, or above `most`."""
    if not (math.isfinite(value) and 0 < value <= most):
        limit = f", at most {most:g}" if math.isfinite(most) else ""
        raise UsageError(f"{option} is {value}; expected a number above 0{limit}")


def _size(text: str) -> tuple[int, int | None]:
    """`WIDTH` or `WIDTHxHEIGHT` in pixels."""
    width, _, height = text.lower().partition("x")
    fits = all(part.isascii() and part.isdigit() and 64 <= int(part) <= 8192
               for part in (width, height or "64"))  # fmt: skip
    if not fits or text.lower().endswith("x"):
        raise UsageError(f"--size is {text}; expected WIDTH or WIDTHxHEIGHT, 64 to 8192 pixels")
    return int(width), int(height) if height else None


def written(console: Console, target: Path, content: bytes) -> int:
    """Write a file and say so; the exit status."""
    from stplan.files.atomic import write_atomically

    write_atomically(target, content)
    console.result(str(target))
    console.result_json({"exit_status": 0, "file": str(target), "bytes": len(content)})
    return 0
