"""Tasks of a file: drawn with the scene's seed, or read from a table; and what does not go with them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stplan.amounts import LARGEST, amount
from stplan.arrays import Point
from stplan.scene.format.agents import AgentFile
from stplan.scene.format.file import SceneFile
from stplan.scene.format.tasks import MOST_TASKS, TasksFile
from stplan.scene.model import Scene
from stplan.scene.places import Place
from stplan.scene.reading.draws import scattered
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.patterns import Listed
from stplan.scene.reading.places import Places
from stplan.scene.reading.regions import OFF_WALLS, floor_of, region_of
from stplan.scene.reading.tables import table_rows
from stplan.scene.tasks import RobotTask
from stplan.schema.mapping import Fault

if TYPE_CHECKING:
    import shapely

_COLUMNS = ("agent", "x", "y", "service")
_DRAWN = ("places", "points", "each", "shared")


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
        known = len(faults)
        floor = floor_of(scene, faults)
        if len(faults) > known:
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
    names = [agent.id for agent in scene.agents]

    def read(cells: dict[str, str]) -> tuple[RobotTask, list[str]]:
        agent, wrong = cells.get("agent"), []
        if agent is not None and agent not in names:
            hint = hints(agent, names) or "; the id of one is expected"
            wrong.append(f"agent is {agent!r}, which is no agent's id{hint}")
        x, y = (_number(key, cells[key], -LARGEST, "a number of m", wrong) for key in ("x", "y"))
        service = cells.get("service") or str(entry.service or 0.0)
        stay = _number("service", service, 0.0, "a time in s", wrong)
        return RobotTask(agent, (x, y), stay, "tasks.file"), wrong

    return tuple(
        table_rows(
            entry.file or "", directory, "tasks.file", faults,
            needed=("x", "y"), known=_COLUMNS, most=MOST_TASKS, read=read,
        )
    )  # fmt: skip


def _number(key: str, cell: str, low: float, what: str, wrong: list[str]) -> float:
    """The number of a cell, with a sentence among the `wrong` where it is none from `low` on."""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not low <= value <= LARGEST:
        wrong.append(f"{key} is {cell!r}; {what} is expected")
    return value
