"""The kinds of values a scene file holds, as types that validate and describe themselves.

All are strict: no number in quotes, no boolean for a number; a whole number does for a float. Empty
values (YAML's null) are refused: whoever wants a default leaves the key out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from stplan.amounts import LARGEST

# Lengths, masses and durations below this vanish beside any coordinate.
SMALLEST = 1e-9
# Weights beyond this are no weights.
HEAVIEST = 1e24
LONGEST_IDENTIFIER = 100
MOST_POINTS = 1_000_000
# Apart from white space: CSV, shell and `--set` give these a meaning of their own.
RESERVED = ",;=\"'`[]{}\\"


def expected(sentence: str, words: Sequence[str] = ()) -> PydanticCustomError:
    """The error of a value where `sentence` ("a number or auto"), or one of `words`, was expected."""
    context = {"expected": sentence, "words": list(words)}
    return PydanticCustomError("expected", "{expected}", context)


class NotNull:
    """Makes `X | None` mean: X, or the key is not there."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        schema = handler(source)
        return schema["schema"] if schema["type"] == "nullable" else schema


class Or:
    """Makes the type it annotates mean: a `number`, or one of some words, and one error if neither."""

    def __init__(self, number: Any, *words: str) -> None:
        self._number, self._words = number, words

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_wrap_validator_function(
            self._validate,
            handler.generate_schema(self._number),
            serialization=core_schema.plain_serializer_function_ser_schema(lambda value: value),
        )

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        number = handler(schema)
        return {"anyOf": [{"enum": list(self._words)}, number]}

    def _validate(self, value: Any, handler: core_schema.ValidatorFunctionWrapHandler) -> Any:
        if isinstance(value, str):
            if value in self._words:
                return value
            raise expected(f"a number or {' or '.join(self._words)}", self._words)
        return handler(value)


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise expected(f"at least {SMALLEST:g}")
    return value


def _whole_one(value: Any) -> Any:
    """Python takes True and 1.0 for 1."""
    if isinstance(value, bool | float):
        raise expected("1, the only version of the format there is,")
    return value


Version = Annotated[Literal[1], BeforeValidator(_whole_one)]
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, le=LARGEST, allow_inf_nan=False), AfterValidator(_not_tiny)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST, allow_inf_nan=False)]
# A factor that may be as small as it likes.
Factor = Annotated[float, Field(gt=0, le=LARGEST, allow_inf_nan=False)]
# Weights are as large as costs, and those of a plan in millimetres a million times as large.
Weight = Annotated[float, Field(ge=0, le=HEAVIEST, allow_inf_nan=False)]
BarrierWeight = Annotated[float, Field(gt=0, le=HEAVIEST, allow_inf_nan=False)]


def _fixed(count: int, form: str) -> BeforeValidator:
    def check(value: Any) -> Any:
        if not isinstance(value, list) or len(value) != count:
            raise expected(form)
        return value

    return BeforeValidator(check)


Point = Annotated[list[Number], Field(min_length=2, max_length=2), _fixed(2, "a point [x, y] in m")]
Velocity = Annotated[
    list[Number], Field(min_length=2, max_length=2), _fixed(2, "a velocity [vx, vy] in m/s")
]
Knot = Annotated[
    list[Number], Field(min_length=3, max_length=3), _fixed(3, "a knot [x, y, t] in m and s")
]
Rectangle = Annotated[
    list[Number],
    Field(min_length=4, max_length=4),
    _fixed(4, "a rectangle [xmin, ymin, xmax, ymax] in m"),
]
Interval = Annotated[
    list[Number], Field(min_length=2, max_length=2), _fixed(2, "an interval [from, to] in s")
]
Ring = Annotated[list[Point], Field(min_length=3, max_length=MOST_POINTS)]
Polyline = Annotated[list[Point], Field(min_length=2, max_length=MOST_POINTS)]


def _identifier(text: str) -> str:
    bad = [c for c in text if c.isspace() or not c.isprintable() or c in RESERVED]
    if bad:
        shown = bad[0] if bad[0].isprintable() and not bad[0].isspace() else f"U+{ord(bad[0]):04X}"
        raise expected(f"a name without white space and without any of {RESERVED} (not {shown})")
    return text


Identifier = Annotated[
    str, Field(min_length=1, max_length=LONGEST_IDENTIFIER), AfterValidator(_identifier)
]
# The same in the words of JSON Schema.
_NAMES_SCHEMA = {
    "anyOf": [
        {"type": "string", "minLength": 1, "maxLength": LONGEST_IDENTIFIER},
        {"type": "array", "minItems": 1, "items": {"type": "string", "minLength": 1}},
    ]
}


def _names(value: Any) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, list) and value and all(isinstance(entry, str) for entry in value):
        return value
    raise expected("an agent's id, all, a list of ids, or {start: PLACE} or {goal: PLACE}")


# Agents of one side of a pair: an id, `all`, or a list of ids.
Names = Annotated[Any, AfterValidator(_names), WithJsonSchema(_NAMES_SCHEMA)]

# Options with which Ipopt writes or loads files anywhere, and options that other keys decide.
REFUSED_OPTIONS = {
    "output_file": "a scene must not name files to write",
    "option_file_name": "options stand in the scene",
    "hsllib": "a scene must not name libraries to load",
    "pardisolib": "a scene must not name libraries to load",
    "linear_solver": "solver.linear_solver sets it",
    "hessian_approximation": "solver.hessian sets it",
    "max_iter": "solver.max_iterations sets it",
}


def _option(value: Any) -> Any:
    """An Ipopt option; YAML has read an unquoted yes or no as a boolean, Ipopt wants the word."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    number = isinstance(value, int | float) and abs(value) <= 1e20
    if number or (isinstance(value, str) and len(value) <= 100):
        return value
    raise expected("text or a number")


Options = dict[
    str,
    Annotated[
        Any,
        AfterValidator(_option),
        WithJsonSchema({"type": ["string", "number", "boolean"]}),
    ],
]
