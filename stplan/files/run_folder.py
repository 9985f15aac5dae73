"""Which scene a run's folder belongs to, as its report.json recorded it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stplan.errors import UsageError
from stplan.files.recorded import REPORT, read_report


@dataclass(frozen=True)
class RecordedScene:
    """The scene of a run: its file, the `--set` overrides it was loaded with, its hash."""

    source: Path
    overrides: tuple[str, ...]
    content_hash: str | None


def recorded_scene(folder: Path, command: str = "check") -> RecordedScene:
    """The scene that the run in `folder` was planned from.

    A relative source is looked for from the working directory, then from the folder and each of
    its parents: a run is usually checked from where it was made, and lies below it.

    Args:
        command: of stplan, for the advice to name the scene.

    Raises:
        UsageError: there is no report, or its scene file is gone.
    """
    folder = Path(folder)
    report = folder / REPORT
    if not report.is_file():
        raise UsageError(
            f"{folder}: holds no {REPORT}, so its scene is unknown; "
            f"name the scene and the trajectories instead: stplan {command} SCENE TRAJECTORIES"
        )
    recorded = read_report(report)
    if recorded.source is None:
        raise UsageError(
            f"{report}: names no scene file; name it yourself: stplan {command} SCENE TRAJECTORIES"
        )
    return RecordedScene(
        _find(Path(recorded.source), folder, report, command),
        recorded.overrides,
        recorded.content_hash,
    )


def _find(source: Path, folder: Path, report: Path, command: str) -> Path:
    home = folder.resolve()
    for candidate in (source, *(base / source for base in (home, *home.parents))):
        if candidate.is_file():
            return candidate
    raise UsageError(
        f"{report}: its scene file {source} is missing; "
        f"name it where it is now: stplan {command} SCENE TRAJECTORIES"
    )
