"""Parts of the plane: how a scene file writes them, by name or in place, and where it may say one."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from stplan.maps.obstacles import CircleFile
from stplan.schema.mapping import GIVEN, FileModel, key
from stplan.schema.quantities import Identifier, Names, Point, Polyline, Rectangle, Ring

MOST_PLACES = 10_000
MOST_POINTS = 10_000
SHAPES = ("rectangle", "polygon", "circle", "line")


class PlaceFile(FileModel):
    """Exactly one shape: an area, or a line such as an exit."""

    rectangle: Annotated[Rectangle | None, GIVEN] = key("[xmin, ymin, xmax, ymax] in m")
    polygon: Annotated[Ring | None, GIVEN] = key("[[x, y], ...] in m, a ring that is not closed")
    circle: Annotated[CircleFile | None, GIVEN] = key("a disc")
    line: Annotated[Polyline | None, GIVEN] = key("[[x, y], ...] in m, a polyline such as an exit")


class StartPlaceFile(PlaceFile):
    """Where an agent starts: a free spot of a place, drawn with seeding.rng_seed."""

    place: Annotated[Identifier | None, GIVEN] = key("name of one of `places`")


class CrowdStartFile(StartPlaceFile):
    """Where a crowd starts: free spots of a place, drawn, or points that are listed."""

    points: Annotated[
        Annotated[list[Point], Field(min_length=1, max_length=MOST_POINTS)] | None, GIVEN
    ] = key("[[x, y], ...] in m, one an agent")


class GoalPlaceFile(PlaceFile):
    """Where an agent ends: anywhere in a place, or in one of several, as is cheapest."""

    place: Annotated[Identifier | None, GIVEN] = key("name of one of `places`")
    any: Annotated[
        Annotated[list[Identifier], Field(min_length=1, max_length=MOST_PLACES)] | None, GIVEN
    ] = key("names of `places`: one of them")


class CrowdGoalFile(GoalPlaceFile):
    """Where a crowd ends: in places, or on points of which everybody gets one."""

    assign: Annotated[
        Annotated[list[Point], Field(min_length=1, max_length=MOST_POINTS)] | None, GIVEN
    ] = key("[[x, y], ...] in m, at least one an agent: who goes where is planned")


class PlacedAgentsFile(FileModel):
    """Those who start in a place, or have it among their goals; with both keys, who does both."""

    start: Annotated[Identifier | None, GIVEN] = key("name of one of `places`: who starts there")
    goal: Annotated[Identifier | None, GIVEN] = key("name of one of `places`: who may end there")


def _kind(value: Any) -> str:
    return "@place" if isinstance(value, dict | PlaceFile) else "@point"


Start = Annotated[
    Annotated[Point, Tag("@point")] | Annotated[StartPlaceFile, Tag("@place")],
    Discriminator(_kind),
]
Goal = Annotated[
    Annotated[Point, Tag("@point")] | Annotated[GoalPlaceFile, Tag("@place")],
    Discriminator(_kind),
]
CrowdGoal = Annotated[
    Annotated[Point, Tag("@point")] | Annotated[CrowdGoalFile, Tag("@place")],
    Discriminator(_kind),
]


def _side_kind(value: Any) -> str:
    return "@place" if isinstance(value, dict | PlacedAgentsFile) else "@names"


# One side of a pair. That the agents and places exist is checked later.
Side = Annotated[
    Annotated[Names, Tag("@names")] | Annotated[PlacedAgentsFile, Tag("@place")],
    Discriminator(_side_kind),
]
