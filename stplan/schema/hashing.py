"""What dataclasses mean as plain JSON, so that their hashes survive new fields."""

from __future__ import annotations

from dataclasses import Field, field, fields, is_dataclass
from typing import Any


def added(default: Any) -> Any:
    """A field that came after others: at its `default` it leaves the hashes of scenes as they were."""
    return field(default=default, metadata={"added": True})


def at_added_default(one: Field[Any], value: Any) -> bool:
    """Whether a field marked as `added` has its default `value`."""
    return "added" in one.metadata and bool(value == one.default)


def meaning(value: Any) -> Any:
    """`value` as plain JSON; fields marked as `added` are left out at their default.

    An object with a `meaning()` of its own speaks for itself.
    """
    own = getattr(value, "meaning", None)
    if own is not None:
        return own()
    if is_dataclass(value):
        return {
            one.name: meaning(getattr(value, one.name))
            for one in fields(value)
            if not at_added_default(one, getattr(value, one.name))
        }
    if isinstance(value, tuple) and not all(isinstance(item, float | int) for item in value):
        return [meaning(item) for item in value]
    return value
