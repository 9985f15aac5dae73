"""A scene in the making, and its text."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from stplan.errors import SceneError, UsageError
from stplan.maps.floor import read_floor
from stplan.maps.reader import MapError
from stplan.maps.registry import MapFile, compile_map
from stplan.scene.format.file import FORMAT
from stplan.schema.mapping import Fault
from stplan.schema.quantities import RESERVED
from stplan.world import FreeSpace

SCHEMA_LINE = "# yaml-language-server: $schema=stplan.schema.json"


@dataclass(frozen=True)
class SceneDraft:
    """What a scene is to say.

    Attributes:
        name: of the scene.
        comments: lines above it.
        map: keys of its map.
        horizon: s, None where every agent has its latest time.
        defaults: of agents.
        agents: their keys.
        pairs: what differs for pairs.
    """

    name: str
    comments: tuple[str, ...]
    map: Mapping[str, Any]
    horizon: float | None
    defaults: Mapping[str, Any]
    agents: tuple[Mapping[str, Any], ...]
    pairs: tuple[Mapping[str, Any], ...] = ()

    def text(self) -> str:
        """The scene as YAML, a line an agent."""
        lines = [
            SCHEMA_LINE,
            *(f"# {line}" for line in self.comments),
            f"stplan: {FORMAT}",
            f"name: {self.name}",
        ]
        if self.map:
            lines.append("map:")
            for key, value in self.map.items():
                if isinstance(value, list) and value and isinstance(value[0], dict):
                    lines += [f"  {key}:", *(f"    - {flow(item)}" for item in value)]
                else:
                    lines.append(f"  {key}: {flow(value)}")
        if self.horizon is not None:
            lines.append(f"horizon: {self.horizon:g}  # s, latest arrival of everybody")
        if self.defaults:
            lines.append(f"defaults: {flow(self.defaults)}  # m, kg")
        lines += ["agents:", *(f"  - {flow(agent)}" for agent in self.agents)]
        if self.pairs:
            lines += ["pairs:", *(f"  - {flow(pair)}" for pair in self.pairs)]
        return "\n".join(lines) + "\n"


def flow(value: Any) -> str:
    """A value on one line; words that mean nothing else stand without quotes."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {flow(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, str):
        plain = re.fullmatch(r"(?:\.\./)*[A-Za-z_][\w./-]*", value) and value.lower() not in _WORDS
        return value if plain else json.dumps(value, ensure_ascii=False)
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


# What YAML takes for something else.
_WORDS = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"}


def free_space_of(tree: Mapping[str, Any], folder: Path) -> tuple[FreeSpace, tuple[str, ...]]:
    """The floor of a map written as `tree`, files looked for in `folder`, and notes about it.

    Raises:
        SceneError: it cannot be used.
    """
    faults: list[Fault] = []
    try:
        entry = MapFile.model_validate(dict(tree))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(step) for step in ("map", *first["loc"]))
        raise UsageError(f"{where}: {first['msg']}") from error
    spec = compile_map(entry, folder, faults)
    if faults:
        raise SceneError([f"{path}: {text}" for path, text in faults])
    try:
        floor = read_floor(spec)
    except MapError as error:
        raise SceneError(f"{error.path}: {error.text}") from error
    notes = tuple(note.sentence for note in floor.notes)
    return FreeSpace.from_polygon(floor.area, None, floor.slits), notes


def identifiers(names: Sequence[str]) -> list[str]:
    """Names as ids: without what ids must not have, each only once."""
    found: dict[str, None] = {}
    for k, name in enumerate(names, 1):
        clean = "".join(
            "-" if c.isspace() or not c.isprintable() or c in RESERVED else c for c in name
        )[:80]
        if not clean or clean == "all":
            clean = f"a{k}"
        number, candidate = 2, clean
        while candidate in found:
            candidate, number = f"{clean}-{number}", number + 1
        found[candidate] = None
    return [*found]


def scene_name(stem: str) -> str:
    """A file's stem as the name of a scene."""
    name = re.sub(r"[^a-z0-9_-]+", "-", stem.lower()).lstrip("-_").rstrip("-")
    return name[:100] or "scene"
