"""Details of plans of very many agents: what would make a report long is kept as arrays beside it.

A report of up to `MOST` agents has all there is to say of each of them. In a longer one every table with more
rows than that says in which arrays of which file its columns are; of clearances the least ones stay.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stplan.files.json_file import json_bytes
from stplan.files.npz_file import arrays_bytes
from stplan.files.recorded import REPORT

DETAILS = "details.npz"
MOST = 1_000

Arrays = dict[str, NDArray[Any]]


def report_files(
    content: Mapping[str, Any], num_agents: int, known: Mapping[str, NDArray[Any]] | None = None
) -> dict[str, bytes]:
    """The report with this `content` on so many agents, and its details if they are many, by file name.

    `known` are arrays that the content names already.
    """
    if num_agents <= MOST:
        return {REPORT: json_bytes(content)}
    short, details = split_details(content)
    return {DETAILS: arrays_bytes({**(known or {}), **details}), REPORT: json_bytes(short)}


def split_details(content: Mapping[str, Any]) -> tuple[dict[str, Any], Arrays]:
    """The `content` of a report without its long tables, and their columns by name: none where none is long.

    Tables are lists of objects, objects of numbers by agent, and objects with `columns` and `rows`. A column
    is named by the keys that lead to it: `metrics.agents.path_length`. What is null there is NaN or "".
    """
    arrays: Arrays = {}
    return {key: _split(item, key, arrays) for key, item in content.items()}, arrays


def _split(value: Any, path: str, arrays: Arrays) -> Any:
    """`value`, which is at `path`, without long tables; their columns go into `arrays`."""
    if isinstance(value, Mapping):
        if {"columns", "rows"} <= value.keys():
            return _split_rows(value, path, arrays)
        if len(value) > MOST and all(isinstance(item, float) for item in value.values()):
            named = {"agent": list(value), "value": list(value.values())}
            return _kept(named, path, arrays)
        return {key: _split(item, f"{path}.{key}", arrays) for key, item in value.items()}
    if isinstance(value, list) and len(value) > MOST and isinstance(value[0], Mapping):
        return _kept({key: [row[key] for row in value] for key in value[0]}, path, arrays)
    return value


def _split_rows(table: Mapping[str, Any], path: str, arrays: Arrays) -> dict[str, Any]:
    rows, columns = table["rows"], table["columns"]
    if len(rows) <= MOST:
        return dict(table)
    where = _kept(dict(zip(columns, zip(*rows, strict=True), strict=True)), path, arrays)
    if "clearance" not in columns:
        return {**table, "rows": [], "others": where}
    clearance = np.array([row[columns.index("clearance")] for row in rows])
    order = np.argsort(clearance, kind="stable")
    where["clearance_above"] = float(clearance[order[MOST]])
    return {**table, "rows": [rows[k] for k in np.sort(order[:MOST]).tolist()], "others": where}


def _kept(columns: Mapping[str, Sequence[Any]], path: str, arrays: Arrays) -> dict[str, Any]:
    """Put a table into `arrays`, and say where it is."""
    names = {f"{path}.{name}": _array(column) for name, column in columns.items()}
    arrays.update(names)
    return {"count": len(next(iter(columns.values()))), "file": DETAILS, "arrays": list(names)}


def _array(column: Sequence[Any]) -> NDArray[Any]:
    kinds = {type(item) for item in column} - {type(None)}
    if kinds <= {float, int, bool}:
        whole = kinds <= {int} and None not in column
        return np.array(column, dtype="<i8" if whole else "<f8")
    return np.array(["" if item is None else str(item) for item in column], dtype=np.str_)
