"""Scenes as text, and what the reader says about them."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan.errors import SceneError
from stplan.scene import parse_scene

PAIR = """\
stplan: 1
name: pair
horizon: 20.0
agents:
  - id: sam
    start: [0.0, 0.0]
    goal: [10.0, 0.0]
    radius: 0.3
  - id: ann
    start: [0.0, 5.0]
    goal: [10.0, 5.0]
    radius: 0.3
"""


def edited(old: str, new: str, text: str = PAIR) -> str:
    """`text` with its first `old` replaced."""
    assert old in text
    return text.replace(old, new, 1)


def refusals(
    text: str, directory: Path | None = None, overrides: tuple[str, ...] = ()
) -> list[str]:
    """All messages about a scene that must be refused."""
    with pytest.raises(SceneError) as refused:
        parse_scene(text, source=Path("scene.yaml"), directory=directory, overrides=overrides)
    return refused.value.messages
