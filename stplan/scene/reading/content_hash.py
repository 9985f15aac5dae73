"""The hash of what a scene means, by which a run knows its scene again."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass
from typing import Any

from stplan.errors import SceneError
from stplan.scene.format.file import FORMAT
from stplan.scene.model import MeshBase, Scene

# Fields that say where a scene is from, not what it means: these stay empty ...
_EMPTY: dict[str, Any] = {"name": "", "source": None, "content_hash": ""}
_EMPTY |= {"locations": {}, "overridden": {}, "agent_paths": ()}
# ... and these, younger than the first hashes, are left out.
_LEFT_OUT = {"overrides"}


def content_hash(scene: Scene) -> str:
    """SHA-256 of the scene's meaning: not of comments, order of keys, formatting or any name of it."""
    meaning: dict[str, Any] = {
        field.name: _EMPTY[field.name]
        if field.name in _EMPTY
        else _meaning(getattr(scene, field.name))
        for field in fields(scene)
        if field.name not in _LEFT_OUT
    }
    digest = hashlib.sha256(f"stplan {FORMAT}\n".encode())
    if scene.map is not None and isinstance(scene.map.base, MeshBase):
        path = scene.map.base.path
        try:
            content = path.read_bytes()
        except OSError as error:
            text = f"cannot be read: {error.strerror}"
            raise SceneError(scene.located("map.mesh", text)) from error
        meaning["map"]["base"]["path"] = "mesh"
        digest.update(hashlib.sha256(content).digest())
    digest.update(json.dumps(meaning, sort_keys=True).encode())
    return digest.hexdigest()


def _meaning(value: Any) -> Any:
    """`value` as plain JSON; fields marked as `added` later are left out at their default."""
    if is_dataclass(value):
        return {
            field.name: _meaning(getattr(value, field.name))
            for field in fields(value)
            if "added" not in field.metadata or getattr(value, field.name) != field.default
        }
    if isinstance(value, tuple) and not all(isinstance(item, float | int) for item in value):
        return [_meaning(item) for item in value]
    return value
