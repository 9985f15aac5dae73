"""The hash of what a scene means, by which a run knows its scene again."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields
from typing import Any

from stplan.scene.format.file import FORMAT
from stplan.scene.model import Scene
from stplan.schema.hashing import at_added_default, meaning

# Fields that say where a scene is from, not what it means: these stay empty ...
_EMPTY: dict[str, Any] = {"name": "", "source": None, "content_hash": ""}
_EMPTY |= {"locations": {}, "overridden": {}, "agent_paths": ()}
# ... and these, younger than the first hashes, are left out.
_LEFT_OUT = {"overrides"}


def content_hash(scene: Scene) -> str:
    """SHA-256 of the scene's meaning: not of comments, order of keys, formatting or any name of it."""
    whole: dict[str, Any] = {
        field.name: _EMPTY[field.name]
        if field.name in _EMPTY
        else meaning(getattr(scene, field.name))
        for field in fields(scene)
        if field.name not in _LEFT_OUT and not at_added_default(field, getattr(scene, field.name))
    }
    digest = hashlib.sha256(f"stplan {FORMAT}\n".encode())
    for content in () if scene.map is None else scene.map.base.contents():
        digest.update(hashlib.sha256(content).digest())
    digest.update(json.dumps(whole, sort_keys=True).encode())
    return digest.hexdigest()
