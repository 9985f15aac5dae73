"""Which scene a run's folder belongs to, as its report.json recorded it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stplan.errors import UsageError
from stplan.files.json_file import read_json

REPORT = "report.json"


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
    scene = read_json(report).get("scene")
    source = scene.get("source") if isinstance(scene, dict) else None
    if not isinstance(scene, dict) or not isinstance(source, str):
        raise UsageError(
            f"{report}: names no scene file; name it yourself: stplan {command} SCENE TRAJECTORIES"
        )
    overrides = scene.get("overrides", [])
    if not isinstance(overrides, list) or not all(isinstance(item, str) for item in overrides):
        raise UsageError(f"{report}: scene.overrides: expected a list of KEY=VALUE")
    content_hash = scene.get("hash")
    return RecordedScene(
        _find(Path(source), folder, report, command),
        tuple(overrides),
        content_hash if isinstance(content_hash, str) else None,
    )


def report_of(folder: Path) -> dict[str, Any]:
    """What the report.json of the run in `folder` holds; raises UsageError where there is none."""
    return read_json(folder / REPORT)


def _find(source: Path, folder: Path, report: Path, command: str) -> Path:
    home = folder.resolve()
    for candidate in (source, *(base / source for base in (home, *home.parents))):
        if candidate.is_file():
            return candidate
    raise UsageError(
        f"{report}: its scene file {source} is missing; "
        f"name it where it is now: stplan {command} SCENE TRAJECTORIES"
    )
