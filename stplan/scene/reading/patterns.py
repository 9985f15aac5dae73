"""Entries of `agents` -> agents: patterns are laid out, tables are read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from stplan.arrays import Point
from stplan.scene.format.agents import (
    MOST_AGENTS,
    AgentFile,
    AgentsCsvFile,
    CirclePatternFile,
    CrowdFile,
    GridPatternFile,
    LinePatternFile,
    PatternFile,
    SharedFields,
    StreamFile,
    WeightsFile,
)
from stplan.scene.reading.crowds import crowd_ends, stream_agents
from stplan.scene.reading.tables import table_rows
from stplan.schema.mapping import Fault

ENDS = ("id", "start_x", "start_y", "goal_x", "goal_y")
# Further columns of a table; a weight is a column such as `weights.arrival`.
WORDS = ("after_arrival",)
NUMBERS = (
    "start_time", "max_time", "preferred_time", "radius", "clearance", "mass", "max_speed",
    "max_acceleration",
)  # fmt: skip
WEIGHTS = tuple(f"weights.{name}" for name in WeightsFile.model_fields)


@dataclass(frozen=True)
class Listed:
    """One agent of the file.

    Attributes:
        id: None where it could not be read.
        agent: None where it could not be read.
        path: where it stands.
        entry: where the keys stand that it shares with others of its pattern or table.
        shared: those keys.
        renamed: what `start` is called there.
    """

    id: str | None
    agent: AgentFile | None
    path: str
    entry: str = ""
    shared: frozenset[str] = frozenset()
    renamed: str = "start"

    def place(self, key: str) -> str:
        """Path of one of its keys."""
        if key == "start" and self.renamed != key:
            return f"{self.entry}.{self.renamed}"
        shared = key.partition(".")[0].partition("[")[0] in self.shared
        return f"{self.entry if shared else self.path}.{key}"


def num_agents(entry: AgentFile | PatternFile | AgentsCsvFile) -> int:
    """How many agents an `entry` stands for; of a table, which has to be read for that, at least.

    Of a stream, whose times may be drawn, about so many.
    """
    if isinstance(entry, GridPatternFile):
        return entry.rows * entry.columns
    if isinstance(entry, CirclePatternFile | LinePatternFile | CrowdFile):
        return entry.count
    if isinstance(entry, StreamFile):
        return max(int(entry.rate * (entry.during[1] - entry.during[0])), 1)
    return 1


def listed_agents(
    entry: AgentFile | PatternFile | AgentsCsvFile,
    path: str,
    directory: Path,
    faults: list[Fault],
    rng_seed: int,
) -> list[Listed]:
    """The agents of an `entry` at `path`; tables are looked for in `directory`.

    Random times of streams are drawn with `rng_seed`.
    """
    if isinstance(entry, AgentFile):
        return [Listed(entry.id, entry, path)]
    shared = {
        key: getattr(entry, key)
        for key in SharedFields.model_fields
        if getattr(entry, key) is not None
    }
    if isinstance(entry, AgentsCsvFile):
        rows = table_rows(
            entry.file, directory, f"{path}.file", faults,
            needed=ENDS, known=(*ENDS, *NUMBERS, *WORDS, *WEIGHTS), most=MOST_AGENTS, read=_row,
        )  # fmt: skip
        return [
            Listed(
                row["id"],
                _joined(shared, row),
                f"{path}.file[{k}]",
                path,
                frozenset(shared) - frozenset(row),
            )
            for k, row in enumerate(rows)
        ]
    if isinstance(entry, StreamFile):
        return [
            Listed(
                f"{entry.id}-{k + 1}",
                _joined(shared, own | {"id": f"{entry.id}-{k + 1}"}),
                f"{path}[{k}]",
                path,
                frozenset(shared) | {"goal"},
                "source",
            )
            for k, own in enumerate(stream_agents(entry, path, faults, rng_seed))
        ]
    if isinstance(entry, CrowdFile):
        starts, goals = crowd_ends(entry, path, faults)
        # All that an agent of a crowd has of its own is its number.
        ends = frozenset({"start", "goal"})
    else:
        starts, goals = _ends(entry)
        ends = frozenset()
    return [
        Listed(
            f"{entry.id}-{k + 1}",
            _joined(shared, {"id": f"{entry.id}-{k + 1}", "start": start, "goal": goal}),
            f"{path}[{k}]",
            path,
            frozenset(shared) | ends,
        )
        for k, (start, goal) in enumerate(zip(starts, goals, strict=True))
    ]


def _joined(shared: Mapping[str, Any], own: Mapping[str, Any]) -> AgentFile:
    """An agent of checked values; its own weights win over shared ones one by one."""
    values = {**shared, **own}
    if "weights" in own and "weights" in shared:
        weights = {
            key: getattr(part, key)
            for part in (shared["weights"], own["weights"])
            for key in part.model_fields_set
        }
        values["weights"] = WeightsFile(**weights)
    return AgentFile.model_construct(**values)


def _ends(entry: PatternFile) -> tuple[list[list[float]], list[list[float]]]:
    """Starts and goals of a pattern."""
    if isinstance(entry, CirclePatternFile):
        first = entry.first_angle or 0.0
        turn = 180.0 if entry.turn is None else entry.turn
        angles = [first + 360.0 * k / entry.count for k in range(entry.count)]
        center, radius = entry.circle.center, entry.circle.radius
        return (
            [_on_circle(center, radius, angle) for angle in angles],
            [_on_circle(center, radius, angle + turn) for angle in angles],
        )
    if isinstance(entry, LinePatternFile):
        return _along(entry.start, entry.count), _along(entry.goal, entry.count)
    if not isinstance(entry, GridPatternFile):
        raise TypeError(f"{type(entry).__name__} is no pattern with ends of its own")
    places = [
        (column * entry.spacing[0], row * entry.spacing[1])
        for row in range(entry.rows)
        for column in range(entry.columns)
    ]
    starts, goals = (
        [[corner[0] + dx, corner[1] + dy] for dx, dy in places]
        for corner in (entry.start, entry.goal)
    )
    return starts, goals


def _on_circle(center: list[float], radius: float, degrees: float) -> list[float]:
    """A point on a circle; opposite ones are opposite to the last bit."""
    half, rest = divmod(degrees % 360.0, 180.0)
    side = -radius if half else radius
    angle = math.radians(rest)
    return [center[0] + side * math.cos(angle), center[1] + side * math.sin(angle)]


def _along(line: list[list[float]], count: int) -> list[list[float]]:
    """`count` points evenly spaced along a polyline, both ends among them; one is in the middle."""
    points: list[Point] = [(x, y) for x, y in line]
    lengths = [math.dist(points[k], points[k + 1]) for k in range(len(points) - 1)]
    total = sum(lengths)
    found = []
    for k in range(count):
        if k == count - 1 and count > 1:
            found.append(list(points[-1]))
            continue
        rest = total * (0.5 if count == 1 else k / (count - 1))
        leg = 0
        while leg < len(lengths) - 1 and rest > lengths[leg]:
            rest -= lengths[leg]
            leg += 1
        part = rest / lengths[leg] if lengths[leg] > 0 else 0.0
        (x0, y0), (x1, y1) = points[leg], points[leg + 1]
        found.append([x0 + part * (x1 - x0), y0 + part * (y1 - y0)])
    return found


def _row(row: Mapping[str, str]) -> tuple[dict[str, Any], list[str]]:
    """Checked values of one row and its faults; empty cells are left out."""
    cells = {key: cell for key, cell in row.items() if cell}
    values: dict[str, Any] = {}
    for key, cell in cells.items():
        place, _, weight = key.partition(".")
        value: Any = cell if key in ("id", *WORDS) or cell == "auto" else _number(cell)
        if weight:
            values.setdefault(place, {})[weight] = value
        elif key in ENDS and key != "id":
            values.setdefault(key[:-2], [None, None])[key.endswith("y")] = value
        else:
            values[key] = value
    missing = [f"{key} is empty" for key in ENDS if key not in cells]
    if missing:
        return {}, missing
    try:
        agent = AgentFile.model_validate(values)
    except ValidationError as error:
        return {}, [_cell_fault(fault["loc"], cells) for fault in error.errors(include_url=False)]
    return {key: getattr(agent, key) for key in agent.model_fields_set}, []


def _number(text: str) -> float | str:
    """The number a cell holds, or its text where it holds none."""
    try:
        return text if "_" in text else float(text)
    except ValueError:
        return text


def _cell_fault(steps: tuple[int | str, ...], cells: Mapping[str, str]) -> str:
    key = str(steps[0])
    if key in ("start", "goal"):
        key += "_y" if steps[-1] == 1 else "_x"
    elif key == "weights":
        key = ".".join(map(str, steps[:2]))
    wanted = {
        "id": "a name without white space, quotes, commas or brackets",
        "after_arrival": "stay or vanish",
    }.get(key, "a number in the range of this key")
    return f"{key} is {cells[key][:60]!r}; {wanted} is expected"
