"""``--set KEY=VALUE``: settings that replace values of a scene file before it is validated."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from stplan.errors import SceneError
from stplan.scene.reading.faults import Hints, shown
from stplan.schema.yaml_nodes import DEEPEST
from stplan.schema.yaml_tree import Tree, read_tree

LONGEST_OVERRIDE = 1_000_000

_KEY = re.compile(r"[^.\[\]]+(?:\[[0-9]+\])*(?:\.[^.\[\]]+(?:\[[0-9]+\])*)*\Z")
_STEP = re.compile(r"([^.\[\]]+)|\[([0-9]{1,9})\]")


def apply_overrides(tree: Tree, overrides: Sequence[str]) -> dict[str, str]:
    """Set every ``KEY=VALUE`` in the tree.

    A key is a path of the file: ``solver.mu``, ``agents[0].radius``, or with an agent's id
    ``agents.sam.radius``. The value is read as YAML. Later ones win.

    Returns:
        the override that decided each path that was set.

    Raises:
        SceneError: every override that cannot be understood or has no place to go.
    """
    decided: dict[str, str] = {}
    messages: list[str] = []
    for override in overrides:
        try:
            path = _apply(tree, override)
        except SceneError as error:
            messages += error.messages
            continue
        inside = (f"{path}.", f"{path}[")
        for inner in [inner for inner in decided if inner.startswith(inside)]:
            del decided[inner]
        decided[path] = _shortened(override)
    if messages:
        raise SceneError(messages)
    return decided


def set_value(root: dict[str, Any], key: str, value: Any) -> None:
    """Put `value` at a `key` like ``agents.sam.radius`` of a plain tree.

    Raises:
        SceneError: there is no such place.
    """
    if not _KEY.match(key):
        raise SceneError(f"{key!r} is no key; one like agents.sam.goal is expected")
    _set(root, [int(m[2]) if m[2] else m[1] for m in _STEP.finditer(key)], value, key)


def _shortened(override: str) -> str:
    return override if len(override) <= 200 else override[:197] + "..."


def _apply(tree: Tree, override: str) -> str:
    name = f"--set {_shortened(override)}"
    key, separator, text = override.partition("=")
    key = key.strip()
    if not separator or not _KEY.match(key) or len(override) > LONGEST_OVERRIDE:
        raise SceneError(f"{name}: KEY=VALUE is expected, as in solver.mu=0.1")
    steps = [int(m[2]) if m[2] else m[1] for m in _STEP.finditer(key)]
    if len(steps) > DEEPEST:
        raise SceneError(f"{name}: a key of at most {DEEPEST} steps is expected")
    # An empty value is left to the validation, which says what it expected instead.
    value = read_tree(text, name, located=False) if text.strip() else Tree()
    if value.faults:
        raise SceneError([f"{name}: {fault}" for _, _, fault in value.faults])
    path = _set(tree.value, steps, value.value, name)
    for known in [known for known in tree.written if known.startswith(path)]:
        del tree.written[known]
    for inner, written in value.written.items():
        tree.written[f"{path}{'.' if inner and inner[0] != '[' else ''}{inner}"] = written
    return path


def _set(root: Any, steps: list[str | int], value: Any, name: str) -> str:
    """Put `value` at `steps`, making mappings on the way; returns the path."""
    at, path = root, ""
    while steps:
        if isinstance(at, list):
            index, used = _entry(at, steps, path, name)
            key: Any = index
            path += f"[{index}]"
        elif isinstance(at, dict) and isinstance(steps[0], str):
            key, used = steps[0], 1
            path = f"{path}.{key}" if path else key
        else:
            what = path or "the scene"
            raise SceneError(f"{name}: {what} is {shown(at)}, which has no {shown(steps[0])}")
        steps = steps[used:]
        if not steps:
            at[key] = value
        elif isinstance(at, dict) and at.get(key) is None:
            at[key] = {}
        at = at[key]
    return path


def _entry(entries: list[Any], steps: list[str | int], path: str, name: str) -> tuple[int, int]:
    """The index that `steps` name in a list, and how many steps name it (an id may hold dots)."""
    first = steps[0]
    if isinstance(first, int):
        if first < len(entries):
            return first, 1
        raise SceneError(f"{name}: {path} has {len(entries)} entries, counted from 0")
    names = [entry.get("id") if isinstance(entry, dict) else None for entry in entries]
    ids = {name: k for k, name in enumerate(names) if isinstance(name, str)}
    word = ""
    for used, step in enumerate(steps, 1):
        if not isinstance(step, str):
            break
        word = f"{word}.{step}" if word else step
        if word in ids:
            return ids[word], used
    raise SceneError(f"{name}: {path} has no entry {first!r}{Hints()(first, ids)}")
