"""The scene file's goals that move: others, whom an agent follows, pursues or evades."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Discriminator, Field, Tag, WithJsonSchema

from stplan.scene.format.places import MOST_PLACES, GoalPlaceFile
from stplan.schema.mapping import GIVEN, FileModel, key
from stplan.schema.quantities import LONGEST_IDENTIFIER, Identifier, Point, Positive, expected

KINDS = ("follow", "pursue", "evade")
_NAME = {"type": "string", "minLength": 1, "maxLength": LONGEST_IDENTIFIER}


def _ids(value: Any) -> Any:
    names = value if isinstance(value, list) else [value]
    if not names or not all(isinstance(name, str) for name in names):
        raise expected("an agent's id, or a list of ids")
    return names


Ids = Annotated[
    Any,
    AfterValidator(_ids),
    WithJsonSchema({"anyOf": [_NAME, {"type": "array", "minItems": 1, "items": _NAME}]}),
]


class MovingGoalFile(FileModel):
    """What an agent wants of others that move: exactly one of follow, pursue and evade."""

    follow: Annotated[Identifier | None, GIVEN] = key("id of an agent to stay near to")
    within: Annotated[Positive | None, GIVEN] = key(
        "how near to whom it follows, m between centres"
    )
    pursue: Annotated[Ids | None, GIVEN] = key(
        "id of an agent to catch, or a list of ids: the nearest one that is left; "
        "who is caught is out of the play"
    )
    capture: Annotated[Positive | None, GIVEN] = key(
        "how near it has to come to catch, m between centres; default: 1.5 times the distance they keep"
    )
    evade: Annotated[Ids | None, GIVEN] = key("id of an agent to run from, or a list of ids")
    places: Annotated[
        Annotated[list[Identifier], Field(min_length=1, max_length=MOST_PLACES)] | None, GIVEN
    ] = key("names of `places`: where it looks for safety; default: anywhere")


def _kind(value: Any) -> str:
    if isinstance(value, MovingGoalFile):
        return "@moving"
    if isinstance(value, dict):
        return "@moving" if value.keys() & set(KINDS) else "@place"
    return "@place" if isinstance(value, GoalPlaceFile) else "@point"


AgentGoal = Annotated[
    Annotated[Point, Tag("@point")]
    | Annotated[GoalPlaceFile, Tag("@place")]
    | Annotated[MovingGoalFile, Tag("@moving")],
    Discriminator(_kind),
]
