"""Agents on grid maps of the MovingAI benchmarks, beside a solver for grids judged by the same certificate.

Starts and goals are middles of free cells, drawn at random in the largest part of the map; who is there
stays. The rival, LaCAM of pymapf where it is installed, moves agents from cell to cell in equal steps of
time; what it finds is a solution on the grid, and its certificate says whether it is one for discs.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from stplan import planner
from stplan.arrays import BoolArray, IntArray
from stplan.callbacks import Progress
from stplan.errors import SeedingError, UsageError
from stplan.imports.draft import SceneDraft, free_space_of, scene_name
from stplan.optional import require
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.scene.model import Scene

COUNTS, SHARES = (10, 30, 100), (0.3, 0.45)
# s that the rival may search.
RIVAL_SECONDS = 30.0
_PACE = 1.0
_SLACK = 3.0
Cells = list[tuple[int, int]]


@dataclass(frozen=True)
class GridOutcome:
    """What became of one instance.

    Attributes:
        share: radius of the agents, in cells.
        planned: whether a certified plan was found; `status` says how it ended.
        seconds: of planning.
        excess: by how much the plan can be dearer than the best one, a share; nan where that is unknown.
        kinetic: cost over that of straight lines.
        rival: of pymapf: "certified", "broken", "none" found, or "" where it is not installed.
        rival_seconds: of its search.
    """

    map: str
    agents: int
    share: float
    planned: bool
    status: str
    seconds: float
    excess: float
    kinetic: float
    rival: str
    rival_seconds: float


def measure(
    maps: Sequence[Path],
    counts: Sequence[int] = COUNTS,
    shares: Sequence[float] = SHARES,
    rng_seed: int = 0,
    *,
    rival: bool = True,
    progress: Progress,
) -> list[GridOutcome]:
    """Plan every instance.

    Raises:
        UsageError: a file is no grid map, or has fewer free cells than agents.
        SceneError: a map cannot be used.
    """
    if rival:
        require("pymapf", "the rival (--no-rival leaves it out)", "rivals")
    outcomes = []
    for path in maps:
        if path.suffix.lower() != ".map":
            raise UsageError(f"{path}: expected a map that ends in .map")
        free = _free_cells(path)
        for count in counts:
            starts, goals = draw_cells(free, count, rng_seed, path)
            for share in shares:
                scene = grid_scene(path, free, starts, goals, share)
                progress(f"{path.name}: {count} agents of radius {share:g}")
                outcomes.append(_outcome(path, scene, free, starts, goals, share, rival=rival))
    return outcomes


def _free_cells(path: Path) -> BoolArray:
    """(H, W) free cells of the largest connected part, row 0 on top."""
    space, _ = free_space_of({"file": path.name}, path.parent)
    largest = max(shapely.get_parts(space.area), key=lambda part: part.area)
    lines = path.read_text("latin-1").split("map\n", 1)[1].splitlines()
    height, width = len(lines), max(map(len, lines), default=0)
    x, y = np.meshgrid(np.arange(width) + 0.5, height - np.arange(height) - 0.5)
    shapely.prepare(largest)
    return np.asarray(shapely.contains_xy(largest, x, y))


def draw_cells(free: BoolArray, count: int, rng_seed: int, path: Path) -> tuple[Cells, Cells]:
    """Different starts and different goals of `count` agents, (row, column) each."""
    cells: IntArray = np.argwhere(free)
    if len(cells) < count:
        raise UsageError(f"{path}: has {len(cells)} free cells for {count} agents")
    rng = np.random.default_rng([rng_seed, count])
    ends = [cells[rng.choice(len(cells), count, replace=False)].tolist() for _ in range(2)]
    starts, goals = ([(row, column) for row, column in one] for one in ends)
    return starts, goals


def grid_scene(path: Path, free: BoolArray, starts: Cells, goals: Cells, share: float) -> Scene:
    """The scene of agents in the middles of cells."""
    height = len(free)

    def middle(cell: tuple[int, int]) -> list[float]:
        return [cell[1] + 0.5, height - cell[0] - 0.5]

    far = max(abs(a - c) + abs(b - d) for (a, b), (c, d) in zip(starts, goals, strict=True))
    agents = tuple(
        {"id": f"a{k}", "start": middle(start), "goal": middle(goal)}
        for k, (start, goal) in enumerate(zip(starts, goals, strict=True), 1)
    )
    horizon = float(math.ceil(_SLACK * far / _PACE)) + 10.0
    draft = SceneDraft(
        scene_name(path.stem), (), {"file": path.name}, horizon, {"radius": share}, agents
    )
    return parse_scene(draft.text(), directory=path.parent)


def _outcome(
    path: Path,
    scene: Scene,
    free: BoolArray,
    starts: Cells,
    goals: Cells,
    share: float,
    *,
    rival: bool,
) -> GridOutcome:
    began = time.perf_counter()
    planned, status, excess, kinetic = False, "", math.nan, math.nan
    try:
        plan = planner.plan(scene)
        planned, status = plan.certificate.holds, str(plan.status)
        if plan.report.bound is not None and plan.report.bound.excess is not None:
            excess = plan.report.bound.excess
        kinetic = plan.report.metrics.kinetic_over_straight or math.nan
    except SeedingError:
        status = "no initial curves"
    seconds = time.perf_counter() - began
    word, spent = _rival(scene, free, starts, goals) if rival else ("", math.nan)
    return GridOutcome(
        path.stem, len(starts), share, planned, status, seconds, excess, kinetic, word, spent
    )


def _rival(scene: Scene, free: BoolArray, starts: Cells, goals: Cells) -> tuple[str, float]:
    """What the certificate says of the rival's solution, and the seconds of its search."""
    pymapf = require("pymapf.core.solver", "the rival", "rivals")
    grid = require("pymapf.core.grid", "the rival", "rivals").GridMap((~free).tolist())
    lacam = require("pymapf.algorithms.lacam", "the rival", "rivals").LaCAM
    ends = enumerate(zip(starts, goals, strict=True), 1)
    agents = [pymapf.Agent(f"a{k}", start, goal) for k, (start, goal) in ends]
    began = time.perf_counter()
    solution = lacam(time_limit=RIVAL_SECONDS).solve(pymapf.MAPFProblem(grid, agents))
    seconds = time.perf_counter() - began
    if solution is None:
        return "none", seconds
    lines = grid_lines(scene, len(free), solution.paths, max(1, solution.makespan))
    return ("certified" if planner.check(scene, lines).holds else "broken"), seconds


def grid_lines(scene: Scene, height: int, paths: dict[str, Cells], makespan: int) -> WorldLines:
    """Paths over cells as curves: all steps take equally long, and the last ends at the horizon."""
    step = scene.horizon / makespan
    curves = []
    for agent in scene.agents:
        cells = paths[agent.id]
        if len(cells) == 1:
            cells = [*cells, cells[0]]
        curves.append(
            np.array([[c + 0.5, height - r - 0.5, k * step] for k, (r, c) in enumerate(cells)])
        )
    return WorldLines.from_curves([agent.id for agent in scene.agents], curves)
