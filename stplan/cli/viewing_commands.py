"""What the commands that show runs do, given a console: each returns its exit status.

Imports that take time wait inside the functions, so that help and usage errors come at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stplan.cli.console import Console
from stplan.errors import UsageError
from stplan.files.atomic import write_atomically
from stplan.viewing.requirements import require

if TYPE_CHECKING:
    from stplan.viewing.run_view import RunView

_EXPORTS = {"glb": "rods.glb", "jupedsim": "jupedsim.txt"}


def plot_run(
    console: Console,
    run: Path,
    output: Path | None,
    scene: Path | None,
    parts: Sequence[str],
    *,
    seed: bool,
    dpi: float,
) -> int:
    """Draw the figure of a run."""
    require("matplotlib", "stplan plot")
    from stplan.viewing.figure import FORMATS, PARTS, figure_bytes

    unknown = [part for part in parts if part not in PARTS]
    if unknown:
        raise UsageError(f"--show: {unknown[0]!r} is none of {', '.join(PARTS)}")
    _check_positive("--dpi", dpi, most=1200)
    target = output or _beside(run, "plot.png")
    kind = _kind(target, FORMATS)
    (view,) = _open(console, [run], scene)
    if seed and view.seed is None:
        console.progress(f"note: {run} holds no initial curves to draw behind its trajectories")
    content = figure_bytes(view, kind, parts=tuple(parts), seed=seed, dpi=dpi)
    return _written(console, target, content)


def animate_runs(
    console: Console,
    runs: Sequence[Path],
    output: Path | None,
    scene: Path | None,
    *,
    fps: float,
    speed: float | None,
    size: str,
) -> int:
    """Make a movie of runs, side by side."""
    require("matplotlib", "stplan animate")
    from stplan.viewing.movie import FORMATS, movie_bytes

    _check_positive("--fps", fps)
    if speed is not None:
        _check_positive("--speed", speed)
    pixels = _size(size)
    target = output or _beside(runs[0], "movie.mp4")
    kind = _kind(target, FORMATS)
    if kind == "mp4":
        require("imageio_ffmpeg", "an MP4 movie")
    views = _open(console, runs, scene)
    titles = [view.title for view in views]
    if len(set(titles)) < len(titles):
        titles = [str(run) for run in runs]
    with console.live_line() as live:
        content = movie_bytes(
            views, titles, kind, fps=fps, speed=speed, size=pixels,
            progress=lambda line: live(lambda: line) if live else None,
        )  # fmt: skip
    return _written(console, target, content)


def view_run(console: Console, run: Path, output: Path | None, scene: Path | None) -> int:
    """Write the interactive page of a run."""
    from stplan.viewing.page import page_bytes

    target = output or _beside(run, "view.html")
    _kind(target, ("html",))
    (view,) = _open(console, [run], scene)
    return _written(console, target, page_bytes(view))


def export_run(
    console: Console,
    run: Path,
    output: Path | None,
    scene: Path | None,
    *,
    form: str,
    fps: float,
    pace: float | None,
) -> int:
    """Write a run for other programs."""
    if form not in _EXPORTS:
        raise UsageError(f"--format: {form!r} is none of {', '.join(_EXPORTS)}")
    _check_positive("--fps", fps)
    if pace is not None:
        _check_positive("--pace", pace)
    target = output or _beside(run, _EXPORTS[form])
    (view,) = _open(console, [run], scene)
    if form == "glb":
        from stplan.viewing.glb_file import glb_bytes

        return _written(console, target, glb_bytes(view, pace))
    from stplan.viewing.jupedsim_file import jupedsim_bytes

    return _written(console, target, jupedsim_bytes(view, fps))


def _open(console: Console, runs: Sequence[Path], scene: Path | None) -> list[RunView]:
    from stplan.viewing.run_view import open_run

    views = [open_run(run, scene) for run in runs]
    for note in dict.fromkeys(note for view in views for note in view.notes):
        console.progress(f"note: {note}")
    return views


def _beside(run: Path, name: str) -> Path:
    """Where a file goes unless told: into the run's folder; of initial curves by their name."""
    if run.is_dir():
        return run / name
    return run.parent / (f"seed-{name}" if run.stem == "seed" else name)


def _kind(target: Path, known: Sequence[str]) -> str:
    kind = target.suffix.lower().removeprefix(".")
    if kind not in known:
        raise UsageError(f"{target}: expected a name ending in .{', .'.join(known)}")
    return kind


def _check_positive(option: str, value: float, most: float = math.inf) -> None:
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


def _written(console: Console, target: Path, content: bytes) -> int:
    write_atomically(target, content)
    console.result(str(target))
    console.result_json({"exit_status": 0, "file": str(target), "bytes": len(content)})
    return 0
