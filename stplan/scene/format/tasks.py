"""The scene file's tasks: drawn from places and points, or from a table."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from stplan.scene.format.places import MOST_PLACES
from stplan.schema.mapping import GIVEN, FileModel, key
from stplan.schema.quantities import Identifier, NotNegative, Point

MOST_TASKS = 100_000
_COUNT = Annotated[int, Field(ge=1, le=MOST_TASKS)]


class TasksFile(FileModel):
    """What robots have to do, one task after another: drawn, or as a table says."""

    places: Annotated[
        Annotated[list[Identifier], Field(min_length=1, max_length=MOST_PLACES)] | None, GIVEN
    ] = key("names of `places` that tasks are drawn from")
    points: Annotated[
        Annotated[list[Point], Field(min_length=1, max_length=MOST_TASKS)] | None, GIVEN
    ] = key("[[x, y], ...] in m that tasks are drawn from")
    each: Annotated[_COUNT | None, GIVEN] = key("how many tasks are drawn for every agent")
    shared: Annotated[_COUNT | None, GIVEN] = key(
        "how many tasks are drawn for all together: whoever is free takes the nearest"
    )
    file: Annotated[Annotated[str, Field(min_length=1, max_length=1000)] | None, GIVEN] = key(
        "instead of all these, a CSV table with the columns x, y in m, path relative to the scene file; "
        "agent: whose task it is, without it whoever is free; service: s"
    )
    service: Annotated[NotNegative | None, GIVEN] = key(
        "how long whoever does a task stands there, s", 0.0
    )
