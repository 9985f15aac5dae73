"""Which runs a batch consists of: scene files found, settings swept, names given."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from stplan.batch.sweep import Combination, combinations
from stplan.errors import SceneError, UsageError

_SUFFIXES = {".yaml", ".yml"}


@dataclass(frozen=True)
class Run:
    """One scene with one set of overrides: all that a worker needs, wherever it is.

    Attributes:
        name: of the run and its folder, unique in the batch.
        source: the scene file as it was named.
        directory: the folder of the scene file, absolute; its maps are looked for from there.
        text: what the scene file holds.
        overrides: KEY=VALUE settings, those of the sweep last.
        content_hash: of the scene, its mesh and its settings; empty where it was refused.
        refusal: what is wrong with the scene, a message a line.
    """

    name: str
    source: Path
    directory: Path
    text: str
    overrides: tuple[str, ...]
    content_hash: str = ""
    refusal: tuple[str, ...] = ()


def list_runs(
    sources: Sequence[str],
    *,
    output: Path,
    overrides: Sequence[str] = (),
    sweeps: Sequence[str] = (),
    filters: Sequence[str] = (),
) -> list[Run]:
    """The runs of a batch, by scene in the order given (sorted within folders and patterns).

    Args:
        sources: scene files, folders of them (searched to any depth) and glob patterns.
        output: the batch's own folder, which is left out when a folder is searched.
        overrides: KEY=VALUE settings of every run.
        sweeps: KEY=a,b,c settings; every combination is a run of its own.
        filters: glob patterns; only runs with a name that matches one of them are kept.

    Raises:
        UsageError: a source or a sweep cannot be understood, nothing is left, or two scenes have
            one name.
    """
    chosen = combinations(sweeps)
    runs: dict[str, Run] = {}
    for source in _scene_files(sources, output):
        for combination in chosen:
            run = _run(source, tuple(overrides), combination)
            if filters and not any(fnmatchcase(run.name, pattern) for pattern in filters):
                continue
            if run.name in runs:
                raise UsageError(
                    f"{runs[run.name].source} and {source} both make a run named {run.name}, so one "
                    "would overwrite the other; rename a scene, or run them into two folders"
                )
            runs[run.name] = run
    if not runs:
        raise UsageError(f"no run matches --filter {' '.join(filters)}")
    return list(runs.values())


def _scene_files(sources: Sequence[str], output: Path) -> list[Path]:
    """Every scene file once, in order."""
    found: dict[str, Path] = {}
    for source in sources:
        for path in _expand(source, output):
            found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def _expand(source: str, output: Path) -> Iterator[Path]:
    path = Path(source)
    if path.is_dir():
        files = sorted(_search(path, Path(os.path.realpath(output))))
        if not files:
            raise UsageError(f"{source}: the folder holds no scene files (*.yaml, *.yml)")
        yield from files
    elif path.exists() or not glob.has_magic(source):
        if not path.exists():
            raise UsageError(f"cannot read {source}: no such file")
        yield path
    else:
        names = sorted(name for name in glob.glob(source, recursive=True) if Path(name).is_file())
        if not names:
            raise UsageError(f"{source}: no file matches this pattern")
        yield from map(Path, names)


def _search(folder: Path, output: Path) -> Iterator[Path]:
    for root, folders, names in os.walk(folder):
        at = Path(root)
        folders[:] = [
            name
            for name in folders
            if not name.startswith(".") and Path(os.path.realpath(at / name)) != output
        ]
        yield from (
            at / name
            for name in names
            if Path(name).suffix.lower() in _SUFFIXES and not name.startswith(".")
        )


def _run(source: Path, overrides: tuple[str, ...], combination: Combination) -> Run:
    from stplan.scene import parse_scene
    from stplan.scene.reading.load import read_text

    settings = overrides + combination.overrides
    content_hash = text = ""
    refusal: tuple[str, ...] = ()
    # A scene that cannot be read has no name; its path says which one is meant.
    name = str(source)
    try:
        text = read_text(source)
        scene = parse_scene(text, source=source, directory=source.parent, overrides=settings)
        name, content_hash = scene.name, scene.content_hash
    except SceneError as error:
        refusal = tuple(error.messages)
    if combination.label:
        name = f"{name}--{combination.label}"
    directory = Path(os.path.abspath(source.parent))
    return Run(name, source, directory, text, settings, content_hash, refusal)
