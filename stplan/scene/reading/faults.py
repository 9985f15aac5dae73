"""What is wrong with a scene, as sentences with file, line, column and path."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from typing import Any, get_args

from pydantic import BaseModel, Tag, ValidationError

from stplan.errors import SceneError
from stplan.scene.format.agents import KINDS, AgentFile
from stplan.scene.format.file import SceneFile
from stplan.scene.model import located
from stplan.schema.mapping import Fault
from stplan.schema.yaml_tree import Tree

# Beyond these, looking for similar words costs more than it helps.
MOST_HINTS = 100
MOST_CHOICES = 2000

_WALL = re.compile(r"map\.obstacles\[\d+\]\.polygon\Z")
_EXPECTED = {
    "greater_than": "more than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "less_than": "less than {lt:g}",
    "less_than_equal": "at most {le:g}",
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing_size": "a whole number of fewer digits",
    "string_type": "text",
    "bool_type": "true or false",
    "list_type": "a list",
    "dict_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "literal_error": "{expected}",
    "too_short": "at least {min_length}",
    "too_long": "at most {max_length}",
    "string_too_short": "text of at least {min_length} character",
    "string_too_long": "text of at most {max_length} characters",
    "string_pattern_mismatch": "text that matches {pattern}",
    "expected": "{expected}",
}


class Hints:
    """``; did you mean 'x'?``, for as many faults as anyone would read."""

    def __init__(self) -> None:
        self._left = MOST_HINTS

    @property
    def spent(self) -> bool:
        """Whether there have been so many that nobody reads more."""
        return not self._left

    def __call__(self, word: object, choices: Iterable[str]) -> str:
        """The hint, or nothing where no choice is close to `word`."""
        known = list(choices)
        if (
            not isinstance(word, str)
            or word in known
            or not self._left
            or len(known) > MOST_CHOICES
        ):
            return ""
        self._left -= 1
        by_lower = {choice.lower(): choice for choice in known}
        close = difflib.get_close_matches(word[:100].lower(), by_lower, n=1, cutoff=0.6)
        near = by_lower[close[0]] if close else word
        return "" if near == word else f"; did you mean '{near}'?"


def sentences(error: ValidationError, tree: Tree, hints: Hints) -> list[Fault]:
    """(path, what is wrong and what is expected) of every fault pydantic found."""
    found: dict[str, str] = {}
    for fault in error.errors(include_url=False):
        steps = fault["loc"]
        path = join(step for step in steps if step not in KINDS)
        kind = fault["type"]
        if kind == "extra_forbidden":
            text = _unknown(steps, hints)
        elif kind == "missing":
            meaning = _fields_at(steps[:-1])[str(steps[-1])].description
            text = f"is missing; expected is: {meaning}"
        else:
            text = _sentence(kind, fault, tree.written.get(path), hints)
            if kind == "too_short" and _WALL.match(path):
                text += "; a wall without an area is a `line`"
        found.setdefault(path, text)
    return list(found.items())


def _fields_at(steps: Iterable[str | int]) -> dict[str, Any]:
    """The keys of the format at `steps`."""
    at: Any = SceneFile
    for step in steps:
        if step in KINDS:
            at = _of_kind(at, str(step))
        elif isinstance(step, str):
            inner = _inner_model(at)
            # A name that a file gives, as of a place, leads to the model itself.
            at = inner.model_fields[step].annotation if step in inner.model_fields else inner
    return dict(_inner_model(at).model_fields)


def _of_kind(annotation: Any, kind: str) -> Any:
    """The member of a union that is tagged `kind`, inside lists and optional ones of it."""
    if any(isinstance(part, Tag) and part.tag == kind for part in get_args(annotation)[1:]):
        return annotation
    for argument in get_args(annotation):
        found = _of_kind(argument, kind)
        if found is not None:
            return found
    return None


def _inner_model(annotation: Any) -> Any:
    """The model inside `X | None`, `list[X]` or an annotated one of these."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in get_args(annotation):
        inner = _inner_model(argument)
        if inner is not None:
            return inner
    return None


def _unknown(steps: tuple[str | int, ...], hints: Hints) -> str:
    known = _fields_at(steps[:-1])
    if steps[0] == "defaults" and len(steps) == 2 and steps[1] in AgentFile.model_fields:
        return "is for each agent to say; any other key of agents is expected in defaults"
    *most, last = known
    all_known = "" if hints.spent else f"; {', '.join(most)} and {last} are known"
    return "unknown key" + (hints(steps[-1], known) or all_known)


def _sentence(kind: str, fault: Any, written: str | None, hints: Hints) -> str:
    context = fault.get("ctx", {})
    value = fault["input"]
    if kind not in _EXPECTED:
        return f"is {shown(value)}: {fault['msg']}"
    wanted = _EXPECTED[kind].format(**context)
    what = shown(value)
    if kind in {"too_short", "too_long"} and isinstance(value, list):
        what = f"a list of {len(value)}"
    elif isinstance(value, float) and not math.isfinite(value):
        wanted = "a finite number"
    elif kind == "float_type" and isinstance(value, int) and not isinstance(value, bool):
        what, wanted = "a number too large for a float", "at most 1e+09"
    text = f"is {what}; {wanted} is expected"
    if value is None:
        text += " (leave the key out for its default)"
    if kind == "string_type" and written is not None:
        text += f" (YAML reads an unquoted {written} as {shown(value)}; in quotes it is text)"
    elif kind == "string_type" and isinstance(value, int | float):
        text += f" (in quotes it is text: '{shown(value)}')"
    elif kind in {"float_type", "int_type", "literal_error"} and isinstance(value, str):
        text += _why_text(value)
    if kind == "literal_error":
        choices = str(context["expected"]).replace("'", "").replace(" or ", ", ")
        text += hints(value, choices.split(", "))
    elif "words" in context:
        text += hints(value, context["words"])
    return text


def _why_text(value: str) -> str:
    """Why something that looks like a number is text."""
    try:
        float(value)
    except ValueError:
        return ""
    return " (leave out the quotes, and zeros in front)"


def shown(value: Any) -> str:
    """A value as one would write it in the file, shortened."""
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def join(steps: Iterable[str | int]) -> str:
    """agents, 2, radius -> ``agents[2].radius``."""
    path = ""
    for step in steps:
        path += f"[{step}]" if isinstance(step, int) else (f".{step}" if path else step)
    return path


def scene_error(
    name: str, tree: Tree, overridden: dict[str, str], faults: Iterable[Fault]
) -> SceneError:
    """All faults in the order of the file, those of overrides last, as one error."""
    messages: dict[str, tuple[bool, int, int]] = {}
    # What the reader stepped over left a hole, about which nothing more is said.
    holes = {path for path, _, _ in tree.faults}
    for path, (line, column), text in tree.faults:
        message = (
            f"{name}:{line}:{column}: {path}: {text}"
            if path
            else (f"{name}:{line}:{column}: {text}")
        )
        messages[message] = (False, line, column)
    for path, text in faults:
        if path in holes:
            continue
        message, place = located(name, tree.locations, overridden, path, text)
        messages.setdefault(message, (place is None, *(place or (0, 0))))
    return SceneError(sorted(messages, key=messages.__getitem__))
