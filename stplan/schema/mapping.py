"""What every mapping of a scene file has in common: strict keys, and how one is left out."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from stplan.schema.quantities import NotNull

# A path of a file such as `agents[2].radius`, and what is wrong there.
Fault = tuple[str, str]

GIVEN = NotNull()


def key(description: str, default: float | str | bool | None = None) -> Any:
    """A key that may be left out; `default` is what a reader may take for granted then."""
    extra: dict[str, Any] = {} if default is None else {"default": default}
    return Field(None, description=description, json_schema_extra=extra)


class FileModel(BaseModel):
    """A mapping without unknown keys; values are not converted."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
