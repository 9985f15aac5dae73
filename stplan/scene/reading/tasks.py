"""Tasks of a file: drawn with the scene's seed, or read from a table; and what does not go with them."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stplan.amounts import LARGEST, amount
from stplan.arrays import Point
from stplan.maps.reader import Floor, MapError
from stplan.scene.format.agents import AgentFile
from stplan.scene.format.file import SceneFile
from stplan.scene.format.tasks import MOST_TASKS, TasksFile
from stplan.scene.model import Scene
from stplan.scene.places import Place
from stplan.scene.reading.draws import scattered
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.patterns import Listed, table_text
from stplan.scene.reading.places import Places
from stplan.scene.reading.regions import OFF_WALLS, region_of
from stplan.scene.tasks import RobotTask
from stplan.schema.csv_table import CsvTable
from stplan.schema.mapping import Fault

if TYPE_CHECKING:
    import shapely

_COLUMNS = ("agent", "x", "y", "service")
_DRAWN = ("places", "points", "each", "shared")
# Faults of a table that are shown.
MOST_FAULTS = 20


def with_tasks(
    scene: Scene,
    entry: TasksFile,
    places: Places,
    directory: Path,
    faults: list[Fault],
    hints: Hints,
) -> Scene:
    """`scene` with the tasks of an `entry`; with new faults it must not be used."""
    given = [key for key in _DRAWN if getattr(entry, key) is not None]
    if entry.file is not None:
        faults += [(f"tasks.{key}", "goes without a file; leave one out") for key in given]
        return replace(
            scene, tasks=() if given else _listed(scene, entry, directory, faults, hints)
        )
    wrong: list[Fault] = []
    if entry.places is None and entry.points is None:
        wrong.append(("tasks", "has no places, points or file; one is expected"))
    if (entry.each is None) == (entry.shared is None):
        found = "none" if entry.each is None else "both"
        wrong.append(("tasks", f"has {found} of each and shared; one is expected"))
    total = entry.shared or (entry.each or 0) * len(scene.agents)
    if total > MOST_TASKS:
        wrong.append(("tasks.each", f"makes {total} tasks; at most {MOST_TASKS} are expected"))
    known = [
        places.named(name, f"tasks.places[{k}]", wrong, hints)
        for k, name in enumerate(entry.places or [])
    ]
    if wrong:
        faults += wrong
        return scene
    return replace(scene, tasks=_drawn(scene, entry, [one for one in known if one], faults))


def endless_faults(file: SceneFile) -> list[Fault]:
    """Tasks with a horizon, and no horizon without tasks."""
    if file.tasks is None:
        text = "is none, and there are no tasks; a time in s is expected"
        return [("horizon", text)] if file.horizon == "none" else []
    faults: list[Fault] = []
    if file.horizon != "none":
        faults.append(("horizon", "goes on until all tasks are done; `horizon: none` is expected"))
    return faults


def with_some_goal(agent: AgentFile) -> AgentFile:
    """An agent with a goal: where it has none it goes back to its start, which may yet be drawn."""
    if agent.goal is not None or agent.path is not None:
        return agent
    start = agent.start if isinstance(agent.start, list) else [0.0, 0.0]
    return agent.model_copy(update={"goal": start})


def with_homes(scene: Scene, listed: Sequence[Listed]) -> Scene:
    """`scene` in which everybody without a goal goes back to its start in the end."""
    if not scene.tasks:
        return scene
    agents = tuple(
        replace(agent, goal=agent.start)
        if one.agent is not None and one.agent.goal is None and one.agent.path is None
        else agent
        for agent, one in zip(scene.agents, listed, strict=True)
    )
    return replace(scene, agents=agents)


def _drawn(
    scene: Scene, entry: TasksFile, places: Sequence[Place], faults: list[Fault]
) -> tuple[RobotTask, ...]:
    """Tasks at places and points, all as likely; nobody has the same one twice in a row."""
    rng = np.random.default_rng(scene.seeding.rng_seed)
    spots = _Spots(scene, places, entry.points or [], rng, faults)
    if faults:
        return ()
    lists: list[tuple[str | None, int]] = [(None, entry.shared or 0)]
    if entry.each is not None:
        lists = [(agent.id, entry.each) for agent in scene.agents]
    tasks = []
    for agent, count in lists:
        before = -1
        for _ in range(count):
            others = [k for k in range(spots.count) if k != before] or [before]
            before = others[int(rng.integers(len(others)))]
            point, path = spots.drawn(before)
            tasks.append(RobotTask(agent, point, entry.service or 0.0, path))
    return tuple(tasks)


class _Spots:
    """What tasks are drawn from: places, then points."""

    def __init__(
        self,
        scene: Scene,
        places: Sequence[Place],
        points: Sequence[Sequence[float]],
        rng: np.random.Generator,
        faults: list[Fault],
    ) -> None:
        self._points: list[Point] = [(x, y) for x, y in points]
        self._rng = rng
        self._regions: list[shapely.Geometry] = []
        self.count = len(places) + len(points)
        if not places:
            return
        floor: Floor | None = None
        if scene.map is not None:
            from stplan.maps.floor import read_floor

            try:
                floor = read_floor(scene.map)
            except MapError as fault:
                faults.append((fault.path, fault.text))
                return
        radius = max(agent.radius for agent in scene.agents)
        for k, place in enumerate(places):
            region = region_of(place, floor, OFF_WALLS * radius)
            if region.is_empty:
                text = (
                    f"is {place}, which has no point that a disc of {amount(radius)} m can stand on"
                )
                faults.append((f"tasks.places[{k}]", text))
            self._regions.append(region)

    def drawn(self, k: int) -> tuple[Point, str]:
        """A point of one of them, and where that stands in the file."""
        if k >= len(self._regions):
            k -= len(self._regions)
            return self._points[k], f"tasks.points[{k}]"
        while True:
            found = scattered(self._regions[k], 1, self._rng)
            if len(found):
                return (float(found[0, 0]), float(found[0, 1])), f"tasks.places[{k}]"


def _listed(
    scene: Scene, entry: TasksFile, directory: Path, faults: list[Fault], hints: Hints
) -> tuple[RobotTask, ...]:
    """The tasks of a table, in its order."""
    name = entry.file or ""
    table = table_text(name, directory, "tasks.file", faults)
    if table is None:
        return ()
    tasks: list[RobotTask] = []
    bad: list[str] = []
    rows = table.rows()
    try:
        header = [cell.strip() for cell in next(rows, [])]
        bad += _header_faults(header, table)
        for row in () if bad else rows:
            if not any(cell.strip() for cell in row):
                continue
            cells = dict(zip(header, (cell.strip() for cell in row), strict=False))
            wrong = _row_faults(scene, header, row, table, hints)
            bad += [f"line {rows.line_num}: {sentence}" for sentence in wrong]
            if not wrong:
                x, y, service = (
                    float(table.number(cells.get(key) or fallback))
                    for key, fallback in (
                        ("x", ""),
                        ("y", ""),
                        ("service", str(entry.service or 0.0)),
                    )
                )
                tasks.append(RobotTask(cells.get("agent"), (x, y), service, "tasks.file"))
            if len(tasks) > MOST_TASKS or len(bad) > MOST_TASKS:
                bad.insert(0, f"has more than {MOST_TASKS} rows")
                break
    except csv.Error as error:
        bad.append(f"line {rows.line_num}: is not well-formed CSV: {error}")
    if not bad and not tasks:
        bad.append("there is no row after the header")
    more = len(bad) - MOST_FAULTS
    bad = bad[:MOST_FAULTS] + ([f"and {more} more faults"] if more > 0 else [])
    faults += [("tasks.file", f"{name}: {sentence}") for sentence in bad]
    return () if bad else tuple(tasks)


def _header_faults(header: Sequence[str], table: CsvTable) -> list[str]:
    missing = [key for key in ("x", "y") if key not in header]
    if missing:
        return [f"the header lacks {', '.join(missing)}; columns{table.separation(header)}"]
    faults = [
        f"the header has {name!r}; known columns are {', '.join(_COLUMNS)}"
        for name in header
        if name not in _COLUMNS
    ]
    if not faults and len(set(header)) < len(header):
        faults.append("the header has a column twice")
    return faults


def _row_faults(
    scene: Scene, header: Sequence[str], row: Sequence[str], table: CsvTable, hints: Hints
) -> list[str]:
    """What is wrong with one row."""
    if len(row) != len(header):
        return [f"{len(row)} values; {len(header)} are expected"]
    faults = []
    for key, cell in zip(header, (cell.strip() for cell in row), strict=True):
        if key == "agent":
            names = [agent.id for agent in scene.agents]
            if cell not in names:
                hint = hints(cell, names) or "; the id of one is expected"
                faults.append(f"agent is {cell!r}, which is no agent's id{hint}")
        elif key != "service" or cell:
            low = 0.0 if key == "service" else -LARGEST
            try:
                value = float(table.number(cell))
            except ValueError:
                value = math.nan
            if not low <= value <= LARGEST:
                what = "a time in s" if key == "service" else "a number of m"
                faults.append(f"{key} is {cell!r}; {what} is expected")
    return faults
