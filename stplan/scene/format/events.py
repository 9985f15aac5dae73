"""The scene file's events: what becomes different while it is executed."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, WithJsonSchema

from stplan.maps.obstacles import ObstacleFile
from stplan.scene.format.agents import AgentFile
from stplan.schema.mapping import GIVEN, FileModel, key
from stplan.schema.quantities import Identifier, Number, Point, Positive

MOST_EVENTS = 1_000
_ANYTHING = Annotated[Any, WithJsonSchema({})]


class EventFile(FileModel):
    """Something that happens to one agent, to the map, or to any values of the scene."""

    at: Number = Field(description="when it happens, s")
    because: Annotated[Annotated[str, Field(min_length=1, max_length=200)] | None, GIVEN] = key(
        "what happens, in words for reports; default: what the other keys say"
    )
    agent: Annotated[Identifier | None, GIVEN] = key(
        "whom it concerns, with goal, delay or max_speed"
    )
    goal: Annotated[Point | None, GIVEN] = key(
        "[x, y] in m, where the agent goes from now on; its waypoints are dropped"
    )
    delay: Annotated[Positive | None, GIVEN] = key("how long the agent stands still from now on, s")
    max_speed: Annotated[Positive | None, GIVEN] = key("how fast it may go from now on, m/s")
    add: Annotated[AgentFile | None, GIVEN] = key("an agent that appears, now or at its start_time")
    remove: Annotated[Identifier | None, GIVEN] = key("id of an agent that is taken away")
    obstacle: Annotated[ObstacleFile | None, GIVEN] = key("a shape that is cut out of the map")
    until: Annotated[Number | None, GIVEN] = key("when the obstacle is gone again, s")
    set: Annotated[dict[str, _ANYTHING] | None, GIVEN] = key(
        "values by their keys, like agents.sam.goal, as with --set"
    )
