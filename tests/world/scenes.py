"""Scenes in a line."""

from __future__ import annotations

from pathlib import Path

from stplan.scene.model import Scene
from stplan.scene.reading.load import parse_scene

ALONE = "  - {id: a, start: [1, 1], goal: [3, 1], radius: 0.3}"


def scene(
    world: str = "", agents: str = ALONE, folder: Path | None = None, more: str = ""
) -> Scene:
    """A scene of a map (flow YAML, none for the open plane) and agent lines."""
    head = f"map: {world}\n" if world else ""
    return parse_scene(f"stplan: 1\nhorizon: 10\n{more}{head}agents:\n{agents}\n", directory=folder)
