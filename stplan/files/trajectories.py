"""A run's folder: which file is read, and how a whole run is written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stplan.errors import UsageError
from stplan.files.atomic import write_set
from stplan.files.csv_file import csv_bytes, read_csv
from stplan.files.foreign import READERS, is_foreign_table, read_foreign
from stplan.files.npz_file import npz_bytes, read_npz
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene

# Those of a run's folder, in the order in which they are looked for.
TRAJECTORIES = ("trajectories.npz", "trajectories.csv")


def read_trajectories(path: Path, fps: float | None = None) -> WorldLines:
    """Read a .csv or .npz file, a run's folder (there the .npz first), or a file of another program.

    Args:
        fps: frames a second of a file that counts frames and does not say.

    Raises:
        UsageError: there is no such file, or it is not well-formed.
    """
    path = Path(path)
    if path.is_dir():
        path = _in_folder(path)
    if not path.exists():
        raise UsageError(f"cannot read {path}: no such file")
    suffix = path.suffix.lower()
    if suffix in READERS and (suffix != ".csv" or is_foreign_table(path)):
        return read_foreign(path, fps)
    if suffix == ".csv":
        return read_csv(path)
    if suffix == ".npz":
        return read_npz(path).world_lines
    others = ", ".join(name for name in READERS if name != ".csv")
    raise UsageError(
        f"{path}: expected a .csv file, a .npz file or the folder of a run (or {others})"
    )


def write_files(
    folder: Path,
    scene: Scene,
    curves: Mapping[str, WorldLines],
    extra: Mapping[str, bytes] | None = None,
) -> list[Path]:
    """Write every `NAME.csv` and `NAME.npz` of `curves`, then `extra` by file name.

    All appear together or none does. Returns the paths.

    Raises:
        UsageError: the folder cannot be written.
    """
    return write_set(folder, curve_files(scene, curves) | dict(extra or {}))


def curve_files(scene: Scene, curves: Mapping[str, WorldLines]) -> dict[str, bytes]:
    """`NAME.csv` and `NAME.npz` of all `curves`, by file name."""
    contents: dict[str, bytes] = {}
    for name, lines in curves.items():
        contents[f"{name}.csv"] = csv_bytes(lines)
        contents[f"{name}.npz"] = npz_bytes(lines, scene)
    return contents


def _in_folder(folder: Path) -> Path:
    for name in TRAJECTORIES:
        if (folder / name).is_file():
            return folder / name
    seeds = [name for name in ("seed.npz", "seed.csv") if (folder / name).is_file()]
    hint = f"; to read its initial curves, name {folder / seeds[0]}" if seeds else ""
    raise UsageError(f"{folder}: holds no {' or '.join(TRAJECTORIES)}{hint}")
