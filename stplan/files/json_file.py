"""JSON that is the same bytes for the same content: keys as inserted, shortest exact floats.

What JSON cannot say (infinities, not-a-number) becomes null. Lists of plain values stand on one
line, so that a table of clearances reads as a table.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stplan.errors import UsageError

_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False)


def json_bytes(content: object) -> bytes:
    """`content` as UTF-8 JSON, ended by a line feed. Takes numpy scalars and arrays too."""
    return (_render(_plain(content), "") + "\n").encode()


def read_json(path: Path) -> dict[str, Any]:
    """The JSON object in a file; raises UsageError, with the place, where there is none."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from error
    except json.JSONDecodeError as error:
        raise UsageError(f"{path}:{error.lineno}:{error.colno}: {error.msg}") from error
    except ValueError as error:
        raise UsageError(f"{path}: {error}") from error
    if not isinstance(content, dict):
        raise UsageError(f"{path}:1: expected a JSON object")
    return content


def _plain(value: object) -> object:
    """`value` in JSON's own types."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Sequence):
        return [_plain(item) for item in value]
    # numpy's scalars and arrays, without importing numpy for commands that print text only.
    convert = getattr(value, "tolist", None)
    if convert is None:
        raise TypeError(f"{type(value).__name__} has no form in JSON")
    return _plain(convert())


def _render(value: object, indent: str) -> str:
    deeper = indent + "  "
    if isinstance(value, dict) and value:
        rows = [f"{deeper}{_scalar(key)}: {_render(item, deeper)}" for key, item in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        rows = [deeper + _render(item, deeper) for item in value]
        return "[\n" + ",\n".join(rows) + f"\n{indent}]"
    return _scalar(value)


def _scalar(value: object) -> str:
    return _ENCODER.encode(value)
