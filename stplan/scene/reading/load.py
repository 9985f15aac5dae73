"""Scene files -> `Scene`: read, override, validate, fill in defaults, check what keys mean together."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO

from pydantic import ValidationError

from stplan.errors import SceneError
from stplan.scene.format.file import SceneFile
from stplan.scene.model import Scene
from stplan.scene.reading.compile import check_parts, compile_scene, salvage
from stplan.scene.reading.content_hash import content_hash
from stplan.scene.reading.events import compile_events
from stplan.scene.reading.faults import Hints, scene_error, sentences, shown
from stplan.scene.reading.overrides import apply_overrides
from stplan.schema.collector import collector_paused
from stplan.schema.mapping import Fault
from stplan.schema.yaml_nodes import LARGEST_FILE
from stplan.schema.yaml_tree import read_tree


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read, validate and complete a scene file.

    Args:
        path: a YAML file of format 1.
        overrides: ``KEY=VALUE`` settings applied before validation, as in ``solver.mu=0.1``,
            ``agents[0].radius=0.4`` or, by id, ``agents.sam.radius=0.4``.

    Raises:
        SceneError: every fault of the file, each with line, column and path.
    """
    source = Path(path)
    with collector_paused():
        return parse_scene(
            read_text(source), source=source, directory=source.parent, overrides=overrides
        )


def read_standard_input(stream: BinaryIO, overrides: Sequence[str] = ()) -> Scene:
    """The scene that comes on standard input; its map files are looked for from the working directory.

    Raises:
        SceneError: like `load_scene`, with ``-`` for the name of the file.
    """
    return parse_scene(_text(stream, "-"), overrides=overrides, label="-")


def read_text(source: Path) -> str:
    """What a scene file holds; raises SceneError where it cannot be read."""
    try:
        with source.open("rb") as file:
            return _text(file, str(source))
    except FileNotFoundError as error:
        raise SceneError(f"{source}: no such scene file") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{source}: cannot be read: {reason}") from error


def _text(stream: BinaryIO, name: str) -> str:
    content = stream.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        raise SceneError(f"{name}:1:1: the file is larger than {LARGEST_FILE // 2**20} MiB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8", "replace")
        line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
        message = f"the byte 0x{content[error.start]:02x} is not UTF-8; a YAML text is expected"
        raise SceneError(f"{name}:{line}:{column}: {message}") from error


def parse_scene(
    text: str,
    *,
    source: Path | None = None,
    directory: Path | None = None,
    overrides: Sequence[str] = (),
    label: str = "scene",
) -> Scene:
    """Like `load_scene`, from text; map files are looked for in `directory` (default: here).

    Args:
        label: what messages call a text without `source`.
    """
    name = label if source is None else str(source)
    folder = directory or Path()
    hints = Hints()
    tree = read_tree(text, name)
    if not isinstance(tree.value, dict):
        if tree.faults:
            raise scene_error(name, tree, {}, [])
        what = shown(tree.value)
        raise SceneError(
            f"{name}:1:1: is {what}; a scene, a mapping of keys to values, is expected"
        )
    overridden = apply_overrides(tree, overrides)
    try:
        file = SceneFile.model_validate(tree.value)
    except ValidationError as error:
        faults = sentences(error, tree, hints)
        broken = {path for path, _ in faults} | {path for path, _, _ in tree.faults}
        faults += check_parts(salvage(tree.value, broken), folder, hints)
        raise scene_error(name, tree, overridden, faults) from error
    stem = "scene" if source is None else _file_name(source.stem)
    scene, faults = compile_scene(file, stem, source, folder, tree.locations, overridden, hints)
    if faults or tree.faults:
        raise scene_error(name, tree, overridden, faults)
    if file.events:

        def read(value: Any) -> tuple[Scene | None, list[Fault]]:
            try:
                world = SceneFile.model_validate(value)
            except ValidationError as error:
                return None, sentences(error, tree, hints)
            found, wrong = compile_scene(world, stem, source, folder, {}, {}, hints)
            return (None if wrong else replace(found, content_hash=content_hash(found))), wrong

        changes, faults = compile_events(file.events, tree.value, scene, read)
        if faults:
            raise scene_error(name, tree, overridden, faults)
        scene = replace(scene, changes=changes)
    scene = replace(scene, overrides=tuple(overrides))
    return replace(scene, content_hash=content_hash(scene))


def _file_name(stem: str) -> str:
    """A file's stem as an output name."""
    name = re.sub(r"[^a-z0-9_-]+", "-", stem.lower()).lstrip("-_").rstrip("-")
    return name[:100] or "scene"
