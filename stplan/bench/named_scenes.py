"""Shipped scenes that are chosen by name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stplan.errors import UsageError


def chosen_scenes(
    folder: Path, names: Sequence[str], *, small: Sequence[str], every: Sequence[str], full: bool
) -> dict[str, Path]:
    """The files of scenes below `folder`, by their names.

    Args:
        names: what the names of scenes contain; where there is none, all scenes.
        small, every: the scenes of the small measurement, and all that may be named.
        full: whether all are taken where none is named.

    Raises:
        UsageError: there is no such scene.
    """
    chosen = named(every if full or names else small, names)
    files = {scene: folder / f"{scene}.yaml" for scene in chosen}
    for file in files.values():
        if not file.exists():
            raise UsageError(f"cannot read {file}: no such file")
    return files


def named(known: Sequence[str], names: Sequence[str]) -> list[str]:
    """Those of the `known` scenes with one of `names` in their own; all where there is none.

    Raises:
        UsageError: there is no such scene.
    """
    for name in names:
        if not any(name in scene for scene in known):
            raise UsageError(f"no scene {name!r}; there are {', '.join(known)}")
    return [scene for scene in known if not names or any(name in scene for name in names)]
