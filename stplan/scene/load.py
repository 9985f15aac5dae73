"""Scene files -> `Scene`: read, override, validate, fill in defaults, check what keys mean together."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from stplan.errors import SceneError
from stplan.scene.compile import compile_scene
from stplan.scene.faults import did_you_mean, sentences
from stplan.scene.format import FORMAT, SceneFile
from stplan.scene.model import MeshBase, Scene
from stplan.scene.reader import LARGEST_FILE, Tree, read_tree


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
    try:
        if source.stat().st_size > LARGEST_FILE:
            raise SceneError(f"{source}:1:1: the file is larger than {LARGEST_FILE // 2**20} MiB")
        text = source.read_bytes().decode("utf-8-sig")
    except FileNotFoundError as error:
        raise SceneError(f"{source}: no such scene file") from error
    except UnicodeDecodeError as error:
        raise SceneError(f"{source}:1:1: not UTF-8 text; a YAML scene is expected") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{source}: cannot be read: {reason}") from error
    return parse_scene(text, source=source, directory=source.parent, overrides=overrides)


def parse_scene(
    text: str,
    *,
    source: Path | None = None,
    directory: Path | None = None,
    overrides: Sequence[str] = (),
) -> Scene:
    """Like `load_scene`, from text; map files are looked for in `directory` (default: here)."""
    name = str(source) if source is not None else "scene"
    tree = read_tree(text, name)
    if not isinstance(tree.value, dict):
        raise SceneError(f"{name}:1:1: a scene is a mapping of keys to values")
    by_override = apply_overrides(tree, overrides)
    try:
        file = SceneFile.model_validate(tree.value)
    except ValidationError as error:
        raise SceneError(
            [located(name, tree, by_override, path, text) for path, text in sentences(error)]
        ) from error
    default_name = "scene" if source is None else _file_name(source.stem)
    scene, faults = compile_scene(file, default_name, source, directory or Path(), tree.locations)
    if faults:
        raise SceneError([located(name, tree, by_override, path, text) for path, text in faults])
    return _with_hash(scene)


def located(name: str, tree: Tree, by_override: dict[str, str], path: str, text: str) -> str:
    """A fault headed by its place in the file, or by the override it came from."""
    known = path
    while known not in tree.locations and known:
        known = known[: max(known.rfind("."), known.rfind("["), 0)]
    for key, override in by_override.items():
        if path == key or path.startswith((f"{key}.", f"{key}[")):
            return f"--set {override}: {path}: {text}"
    line, column = tree.locations.get(known, (1, 1))
    return f"{name}:{line}:{column}: {path}: {text}" if path else f"{name}:{line}:{column}: {text}"


_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def apply_overrides(tree: Tree, overrides: Sequence[str]) -> dict[str, str]:
    """Set every ``KEY=VALUE`` in the tree; returns which path came from which override."""
    origin = {}
    for override in overrides:
        key, separator, text = override.partition("=")
        steps = [int(m[2]) if m[2] else m[1] for m in _STEP.finditer(key)]
        if not separator or not steps:
            raise SceneError(f"--set {override}: KEY=VALUE is expected, as in solver.mu=0.1")
        value = read_tree(text, f"--set {override}").value if text.strip() else None
        origin[_set(tree.value, steps, value, override)] = override
    return origin


def _set(root: Any, steps: list[str | int], value: Any, override: str) -> str:
    """Put `value` at `steps`, making mappings on the way; returns the path."""
    at, path = root, ""
    for number, step in enumerate(steps):
        last = number == len(steps) - 1
        if isinstance(at, list):
            ids = [entry.get("id") if isinstance(entry, dict) else None for entry in at]
            index = ids.index(step) if step in ids else step
            if not isinstance(index, int) or index >= len(at):
                names = [str(entry) for entry in ids if entry is not None]
                hint = did_you_mean(str(step), names)
                raise SceneError(f"--set {override}: there is no entry {step!r} in {path}{hint}")
            path += f"[{index}]"
            if last:
                at[index] = value
            else:
                at = at[index]
        elif isinstance(at, dict) and isinstance(step, str):
            path = f"{path}.{step}" if path else step
            if last:
                at[step] = value
            else:
                if at.get(step) is None:
                    at[step] = {}
                at = at[step]
        else:
            raise SceneError(f"--set {override}: {path or 'the scene'} holds no {step!r}")
    return path


def _file_name(stem: str) -> str:
    """A file's stem as an output name."""
    name = re.sub(r"[^a-z0-9_-]+", "-", stem.lower()).lstrip("-_")
    return name[:100] or "scene"


def _with_hash(scene: Scene) -> Scene:
    """The scene with the SHA-256 of its meaning: not of comments, key order or file names."""
    from dataclasses import replace

    meaning = asdict(replace(scene, source=None, locations={}, content_hash=""))
    digest = hashlib.sha256(f"stplan {FORMAT}\n".encode())
    if scene.map is not None and isinstance(scene.map.base, MeshBase):
        meaning["map"]["base"]["path"] = "mesh"
        digest.update(hashlib.sha256(scene.map.base.path.read_bytes()).digest())
    digest.update(json.dumps(meaning, sort_keys=True, default=str).encode())
    return replace(scene, content_hash=digest.hexdigest())


__all__ = ["apply_overrides", "load_scene", "parse_scene", "yaml"]
