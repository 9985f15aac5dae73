"""This planner and its rivals on the same scenes, in the same run.

Every agent has the same greatest speed and acceleration. Asked for is the least makespan: the time at
which the last agent arrives. What comes out, whoever found it, is measured by the code of the certificate.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.bench.makespan import fastest
from stplan.bench.rivals import casadi_grid, jupedsim_model, ompl_joint, rvo2
from stplan.bench.rivals.task import Motion, Task
from stplan.callbacks import Progress
from stplan.certify.pair_clearance import nearest_moments
from stplan.certify.wall_clearance import wall_distances
from stplan.errors import UsageError
from stplan.planner import find_initial_curves, prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene import load_scene
from stplan.scene.model import Scene
from stplan.seeding.elastic_bands.geodesics import geodesic_curves
from stplan.world import FreeSpace, build_free_space

NAMES = ("three-symmetric", "three-offset", "circle", "gap", "lane")
OURS = "stplan"
# How long (s) a rival may compute, or simulate.
TIME_LIMIT = 30.0
RIVALS: tuple[tuple[str, str, Callable[[Task], Motion]], ...] = (
    (jupedsim_model.NAME, jupedsim_model.PACKAGE, jupedsim_model.drive),
    (rvo2.NAME, rvo2.PACKAGE, rvo2.drive),
    (ompl_joint.NAME, ompl_joint.PACKAGE, ompl_joint.drive),
    (casadi_grid.NAME, casadi_grid.PACKAGE, casadi_grid.drive),
    (casadi_grid.NAME_WARM, casadi_grid.PACKAGE, casadi_grid.drive_warm),
)


@dataclass(frozen=True)
class Performance:
    """What one planner makes of one scene, nan where it made nothing of it.

    Attributes:
        arrived, agents: how many arrive, of how many.
        makespan: when the last one arrives (s), nan unless all do.
        length: of all paths together (m).
        acceleration: the greatest change of velocity over the time between the middles of segments
            (m/s^2).
        clearance: the smallest, to one another and to walls, in continuous time (m).
        seconds: what it took.
    """

    scene: str
    planner: str
    agents: int
    arrived: int = 0
    makespan: float = np.nan
    length: float = np.nan
    acceleration: float = np.nan
    clearance: float = np.nan
    seconds: float = np.nan
    note: str = ""


def compare_planners(
    folder: Path, names: Sequence[str], *, progress: Progress
) -> list[Performance]:
    """Ours first, then every rival, scene by scene; rivals that are not installed are left out.

    Raises:
        UsageError: `folder` holds no such scene.
    """
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        raise UsageError(f"there is no scene {unknown[0]!r}; expected one of {', '.join(NAMES)}")
    found: list[Performance] = []
    for name in names or NAMES:
        path = folder / f"{name}.yaml"
        if not path.is_file():
            raise UsageError(f"there is no {path}; say where the scenes are with --scenes")
        scene = load_scene(path)
        found.append(our_outcome(scene, name, progress=progress))
        if not installed():
            continue
        task = build_task(scene)
        for planner, package, drive in RIVALS:
            if find_spec(package):
                progress(f"{name}: {planner}")
                found.append(rival_outcome(task, name, planner, drive))
    return found


def installed() -> list[str]:
    """Names of the rivals that can be run."""
    return [planner for planner, package, _ in RIVALS if find_spec(package)]


def our_outcome(scene: Scene, name: str, *, progress: Progress) -> Performance:
    """The certified plan of the least makespan."""
    blank = Performance(name, OURS, len(scene.agents))
    best = fastest(scene, progress=progress)
    if best is None or best.plan.trajectories is None:
        return Performance(name, OURS, len(scene.agents), note="no plan")
    everyone = np.ones(blank.agents, dtype=bool)
    motion = Motion(list(best.plan.trajectories.curves()), everyone, rests=True)
    planned = best.plan.run.seconds["total"]
    note = f"certified; {planned:.1f} s of it are the plan itself"
    return measured(blank, scene, build_free_space(scene), motion, best.seconds, note)


def rival_outcome(
    task: Task, name: str, planner: str, drive: Callable[[Task], Motion]
) -> Performance:
    """One rival on one scene."""
    blank = Performance(name, planner, len(task.scene.agents))
    began = time.perf_counter()
    motion = drive(task)
    seconds = time.perf_counter() - began
    return measured(blank, task.scene, task.free_space, motion, seconds, motion.note)


def build_task(scene: Scene) -> Task:
    """The scene as rivals get it.

    Raises:
        UsageError: the agents differ in speed or acceleration, or have no limits.
    """
    limits = {(agent.max_speed, agent.max_acceleration) for agent in scene.agents}
    speed, acceleration = limits.pop()
    if limits or speed is None or acceleration is None:
        raise UsageError(f"{scene.name}: every agent needs the same max_speed and max_acceleration")
    problem = prepare(scene)
    curves = list(find_initial_curves(problem)[0].world_lines.curves())
    alone = [curve for curve in geodesic_curves(problem) if curve is not None]
    ways = [problem.frame.points(curve[:, :2]) for curve in alone]
    return Task(scene, problem.written.free_space, speed, acceleration, ways, curves, TIME_LIMIT)


def measured(
    blank: Performance,
    scene: Scene,
    free_space: FreeSpace | None,
    motion: Motion,
    seconds: float,
    note: str,
) -> Performance:
    """The figures of a motion; agents count until the end of their curves."""
    if not motion.curves:
        return Performance(blank.scene, blank.planner, blank.agents, seconds=seconds, note=note)
    latest = max(float(curve[-1, 2]) for curve in motion.curves)
    return Performance(
        blank.scene,
        blank.planner,
        blank.agents,
        int(motion.arrived.sum()),
        latest if motion.arrived.all() else np.nan,
        sum(float(np.hypot(*np.diff(curve[:, :2], axis=0).T).sum()) for curve in motion.curves),
        max(greatest_acceleration(curve, rests=motion.rests) for curve in motion.curves),
        smallest_clearance(scene, free_space, motion.curves),
        seconds,
        note,
    )


def greatest_acceleration(curve: FloatArray, *, rests: bool = False) -> float:
    """The greatest change of velocity between neighbouring segments over the time between their middles.

    Where the agent `rests`, it stands still before and after, as the certificate has it.
    """
    step = np.diff(curve, axis=0)
    velocity = step[:, :2] / step[:, 2:]
    between = 0.5 * (step[1:, 2] + step[:-1, 2])
    if rests:
        velocity = np.vstack([np.zeros(2), velocity, np.zeros(2)])
        between = np.concatenate([0.5 * step[:1, 2], between, 0.5 * step[-1:, 2]])
    return float((np.hypot(*np.diff(velocity, axis=0).T) / between).max(initial=0.0))


def smallest_clearance(
    scene: Scene, free_space: FreeSpace | None, curves: Sequence[FloatArray]
) -> float:
    """The smallest clearance of agents to one another and to the walls, in continuous time, m."""
    pairs, distance = smallest_distances(scene, curves)
    radii = np.array([agent.radius for agent in scene.agents])
    gaps = distance - radii[pairs].sum(axis=1)
    smallest = float(gaps.min(initial=np.inf))
    if free_space is not None:
        walls = wall_distances(free_space, curves).distance
        smallest = min(smallest, float((walls - radii).min()))
    return smallest


def smallest_distances(scene: Scene, curves: Sequence[FloatArray]) -> tuple[IntArray, FloatArray]:
    """Pairs (N, 2) of agents and how near their centres come while both are on their way, m."""
    count = len(curves)
    wanted = np.triu(np.ones((count, count), dtype=bool), 1)
    lines = WorldLines.from_curves([agent.id for agent in scene.agents], list(curves))
    leaves = np.array([curve[-1, 2] for curve in curves])
    found = nearest_moments(lines, leaves, wanted)
    return found.pairs, found.distance
