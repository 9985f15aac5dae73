"""JSON of unknown origin -> plain data, within bounds."""

from __future__ import annotations

import json
from typing import Any

from stplan.maps.formats.drawing import FormatError, finite

LARGEST_TEXT = 32 * 1024 * 1024
# Brackets and commas, of which every value costs one.
MOST_VALUES = 4_000_000


def read_json_tree(content: bytes) -> dict[str, Any]:
    """The object that a text holds.

    Raises:
        FormatError: it is no JSON object, or more than is read.
    """
    if len(content) > LARGEST_TEXT or content.count(b",") + content.count(b"[") > MOST_VALUES:
        raise FormatError(
            f"is larger than {LARGEST_TEXT // 2**20} MiB or holds more than {MOST_VALUES} values"
        )
    try:
        tree = json.loads(content.decode("utf-8-sig"), parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise FormatError(f"is no valid JSON: {error.msg}", error.lineno) from error
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise FormatError("is no valid JSON: a byte is not UTF-8", line) from error
    except RecursionError as error:
        raise FormatError("is nested too deep") from error
    except ValueError as error:
        raise FormatError("has a number that is too long or not finite") from error
    if not isinstance(tree, dict):
        raise FormatError("holds no object, which is expected at its top", 1)
    return tree


def _no_constant(name: str) -> float:
    raise ValueError(name)


def members(tree: Any, key: str, path: str = "") -> list[Any]:
    """The list under a key, empty where there is none; raises FormatError where it is no list."""
    found = tree.get(key) if isinstance(tree, dict) else None
    if found is None:
        return []
    if isinstance(found, dict):
        found = list(found.values())
    if not isinstance(found, list):
        raise FormatError(f"{path}{key} is no list")
    return found


def mapping(tree: Any, key: str, path: str = "") -> dict[str, Any]:
    """The object under a key; raises FormatError where there is none."""
    found = tree.get(key) if isinstance(tree, dict) else None
    if not isinstance(found, dict):
        raise FormatError(f"{path}{key} is missing or no object")
    return found


def place(value: Any, path: str) -> tuple[float, float]:
    """[x, y, ...] or {x, y}; raises FormatError for anything else."""
    if isinstance(value, dict):
        value = [value.get("x"), value.get("y")]
    if not isinstance(value, list) or len(value) < 2:
        raise FormatError(f"{path} is no place [x, y]")
    return finite(value[0], f"x of {path}"), finite(value[1], f"y of {path}")


def ring(value: Any, path: str) -> list[tuple[float, float]]:
    """A list of at least three places; raises FormatError for anything else."""
    if not isinstance(value, list) or len(value) < 3:
        raise FormatError(f"{path} is no ring of at least 3 places")
    return [place(one, f"{path}[{k}]") for k, one in enumerate(value)]
