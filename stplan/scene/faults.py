"""Validation errors as sentences with file, line, column and path."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from stplan.scene.format import SceneFile


def sentences(error: ValidationError) -> list[tuple[str, str]]:
    """(path, what is wrong and what is expected) of every fault, in file order, once each."""
    found: dict[str, str] = {}
    for fault in error.errors(include_url=False):
        steps = _steps(fault["loc"])
        path = join(steps)
        kind = fault["type"]
        if kind == "extra_forbidden":
            text = "unknown key" + did_you_mean(str(steps[-1]), _keys_at(steps[:-1]))
        elif kind == "missing":
            text = "is missing"
        else:
            text = _sentence(kind, fault)
        # A union reports one fault a member; together they say what was expected.
        found[path] = text if path not in found else f"{found[path]}; or {text}"
    return list(found.items())


def _steps(location: tuple[Any, ...]) -> list[str | int]:
    """The steps of pydantic's location that are in the file (keys and indices, no union members)."""
    steps: list[str | int] = []
    model: Any = SceneFile
    for step in location:
        if isinstance(step, int):
            steps.append(step)
            continue
        keys = _fields(model)
        known = isinstance(model, type) and step in keys
        if known:
            steps.append(step)
            model = _inner_model(keys[step].annotation)
        elif step == location[-1] and not _is_union_member(step):
            steps.append(step)
    return steps


def _is_union_member(step: str) -> bool:
    return any(mark in step for mark in "[]-(") or step in {"float", "int", "str", "bool", "list"}


def _fields(model: Any) -> dict[str, Any]:
    if isinstance(model, type) and issubclass(model, BaseModel):
        return dict(model.model_fields)
    return {}


def _inner_model(annotation: Any) -> Any:
    """The model inside `X | None`, `list[X]` or an annotated one of these."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in get_args(annotation):
        inner = _inner_model(argument)
        if inner is not None:
            return inner
    return None


def _keys_at(steps: Iterable[str | int]) -> list[str]:
    model: Any = SceneFile
    for step in steps:
        if isinstance(step, str):
            model = (
                _inner_model(_fields(model)[step].annotation) if step in _fields(model) else None
            )
    return list(_fields(model))


def _sentence(kind: str, fault: Any) -> str:
    context = fault.get("ctx", {})
    value = fault["input"]
    shown = repr(value) if len(repr(value)) <= 60 else repr(value)[:57] + "..."
    expected = {
        "greater_than": "more than {gt}",
        "greater_than_equal": "at least {ge}",
        "less_than": "less than {lt}",
        "less_than_equal": "at most {le}",
        "finite_number": "a finite number",
        "float_type": "a number",
        "int_type": "a whole number",
        "int_from_float": "a whole number",
        "string_type": "text",
        "bool_type": "true or false",
        "list_type": "a list",
        "dict_type": "keys with values",
        "model_type": "keys with values",
        "model_attributes_type": "keys with values",
        "literal_error": "{expected}",
        "too_short": "at least {min_length} entries",
        "too_long": "at most {max_length} entries",
        "string_too_short": "at least {min_length} characters",
        "string_too_long": "at most {max_length} characters",
        "string_pattern_mismatch": "text that matches {pattern}",
    }.get(kind)
    if expected is None:
        return f"{shown} does not do: {fault['msg']}"
    if kind == "too_short" and isinstance(value, list):
        shown = f"{len(value)} entries"
    text = f"is {shown}; {expected.format(**context)} is expected"
    if kind == "literal_error" and isinstance(value, str):
        text += did_you_mean(
            value, str(context["expected"]).replace("'", "").replace(",", " ").split()
        )
    return text


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """``; did you mean 'x'?`` or nothing."""
    close = difflib.get_close_matches(word, list(choices), n=1, cutoff=0.6)
    return f"; did you mean '{close[0]}'?" if close else ""


def join(steps: Iterable[str | int]) -> str:
    """agents, 2, radius -> ``agents[2].radius``."""
    path = ""
    for step in steps:
        path += f"[{step}]" if isinstance(step, int) else (f".{step}" if path else step)
    return path
