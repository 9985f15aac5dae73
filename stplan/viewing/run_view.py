"""What there is to see of a run: its curves, and as much of its scene as is left.

A scene may have changed or vanished since a run was planned. The curves and, in .npz files, the
radii are in the run itself; what else is missing is noted and left out of the picture.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.arrays import FloatArray
from stplan.errors import SceneError, UsageError
from stplan.files.npz_file import read_npz
from stplan.files.recorded import REPORT
from stplan.files.run_folder import recorded_scene
from stplan.files.trajectories import read_trajectories
from stplan.planned import Plan
from stplan.problem.continuation import curves_of
from stplan.problem.ends import ending_as
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import whole_scene
from stplan.scene import load_scene
from stplan.scene.model import Scene
from stplan.scene.places import Place
from stplan.scene.presence import present_until
from stplan.world import FreeSpace, build_free_space

_CURVES = ("trajectories.npz", "trajectories.csv", "seed.npz", "seed.csv")


@dataclass(frozen=True)
class RunView:
    """A run as pictures show it; agents in the order of the curves.

    Attributes:
        name, description: the scene's, or the folder's name and nothing.
        title: the name, and whether these are only the initial curves.
        crowd: the agents and their curves.
        seed: the initial curves, None where they are not in the folder or are what is shown.
        waypoints: (x, y) of every agent's waypoints.
        time_scale: m/s.
        notes: a sentence for everything that is missing or differs.
        places: parts of the plane in which agents start and end.
        scene: of the run, None where it is lost.
    """

    name: str
    title: str
    description: str
    crowd: Crowd
    seed: WorldLines | None
    waypoints: tuple[tuple[tuple[float, float], ...], ...]
    time_scale: float
    notes: tuple[str, ...]
    places: tuple[Place, ...] = ()
    scene: Scene | None = None

    @property
    def events(self) -> tuple[tuple[float, str], ...]:
        """When something happened that nobody knew of before, s, and what."""
        changes = () if self.scene is None else self.scene.changes
        return tuple((change.at, "; ".join(change.causes)) for change in changes)

    @property
    def num_agents(self) -> int:
        """Number of agents A."""
        return self.crowd.num_agents

    @property
    def lines(self) -> WorldLines:
        """The curves."""
        return self.crowd.lines

    @property
    def radii(self) -> FloatArray:
        """(A,) m."""
        return self.crowd.radii

    @property
    def free_space(self) -> FreeSpace | None:
        """The map, None where there is none or it is lost."""
        return self.crowd.free_space

    @property
    def begin(self) -> float:
        """When the first agent appears, s."""
        return float(self.lines.knots[self.lines.offsets[:-1], 2].min())

    @property
    def end(self) -> float:
        """When the last agent arrives, s: from then on nothing moves."""
        return float(self.arrivals.max())

    @property
    def arrivals(self) -> FloatArray:
        """(A,) s."""
        return self.crowd.arrivals

    @property
    def leaves(self) -> FloatArray:
        """(A,) until when each agent is seen, s."""
        return self.seen_until(self.end)

    def seen_until(self, end: float) -> FloatArray:
        """(A,) until when each agent is seen in pictures that end at `end`, s."""
        return present_until(self.crowd.stays, self.arrivals, end)

    @cached_property
    def rows(self) -> dict[str, int]:
        """The place of every agent among the curves, by its id."""
        return {agent_id: a for a, agent_id in enumerate(self.lines.agent_ids)}

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """xmin, ymin, xmax, ymax of all that is seen, m."""
        reach = np.repeat(self.radii, np.diff(self.lines.offsets))[:, None]
        low = (self.lines.knots[:, :2] - reach).min(axis=0)
        high = (self.lines.knots[:, :2] + reach).max(axis=0)
        if self.free_space is not None:
            box = self.free_space.polygon.bounds
            low, high = np.minimum(low, box[:2]), np.maximum(high, box[2:])
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def open_run(path: Path, scene_file: Path | None = None) -> RunView:
    """Read a run's folder, or one file of curves in it.

    Args:
        path: the folder (its trajectories are read, or its seed where it has no more), a .csv or a .npz.
        scene_file: the scene, where the run's own record of it is not to be trusted.

    Raises:
        UsageError: there are no curves, time goes back on them, or neither file nor scene tells the radii.
        SceneError: `scene_file` is wrong.
    """
    path = Path(path)
    notes: list[str] = []
    file = _file_of_curves(path, notes)
    folder = file.parent
    lines = read_trajectories(file)
    for agent_id, curve in zip(lines.agent_ids, lines.curves(), strict=True):
        if (np.diff(curve[:, 2]) < 0.0).any():
            raise UsageError(f"{file}: the time of agent {agent_id!r} goes back; see stplan check")
    scene = load_scene(scene_file) if scene_file else _scene_of(folder, notes)
    if scene is not None and scene.changes:
        scene = whole_scene(scene, curves_of(lines))
    if scene is not None and set(lines.agent_ids) != {agent.id for agent in scene.agents}:
        if scene_file:
            raise UsageError(f"{scene_file}: has other agents than {file}")
        notes.append(f"{scene.source} has other agents by now; drawn without it")
        scene = None
    free_space = None
    if scene is not None:
        try:
            free_space = build_free_space(scene)
        except SceneError as error:
            if scene_file:
                raise
            notes.append(f"drawn without the map: {error.messages[0]}")
    radii, time_scale = _sizes(file, lines)
    seed = None
    if file.stem != "seed":
        seed = next(
            (read_trajectories(folder / s) for s in _CURVES[2:] if (folder / s).is_file()), None
        )
    if scene is None:
        if radii is None:
            raise UsageError(
                f"{file}: the radii are neither in it nor in a scene; name the scene: --scene FILE"
            )
        return _without_scene(file, lines, seed, radii, time_scale, tuple(notes))
    problem = PlanningProblem.from_scene(ending_as(scene, lines), free_space)
    crowd = Crowd.of_problem(problem, lines)
    place = {agent.id: agent for agent in scene.agents}
    return RunView(
        name=scene.name,
        title=_title(scene.name, file),
        description=scene.description,
        # As they were when planned, should the scene have changed.
        crowd=crowd if radii is None else replace(crowd, radii=radii),
        seed=seed,
        waypoints=tuple(place[agent_id].waypoints for agent_id in lines.agent_ids),
        time_scale=scene.time_scale,
        notes=tuple(notes),
        places=scene.every_place,
        scene=scene,
    )


def view_plan(plan: Plan) -> RunView:
    """A plan as it is shown, straight from memory."""
    scene = plan.scene
    lines = plan.seed if plan.trajectories is None else plan.trajectories
    problem = PlanningProblem.from_scene(ending_as(scene, lines), build_free_space(scene))
    return RunView(
        name=scene.name,
        title=scene.name if plan.trajectories is not None else f"{scene.name}, initial curves",
        description=scene.description,
        crowd=Crowd.of_problem(problem, lines),
        seed=None if plan.trajectories is None else plan.seed,
        waypoints=tuple(agent.waypoints for agent in scene.agents),
        time_scale=scene.time_scale,
        notes=(),
        places=scene.every_place,
    )


def _file_of_curves(path: Path, notes: list[str]) -> Path:
    if not path.is_dir():
        return path
    found = [path / name for name in _CURVES if (path / name).is_file()]
    if not found:
        raise UsageError(
            f"{path}: holds no trajectories.npz, trajectories.csv, seed.npz or seed.csv"
        )
    if found[0].stem == "seed":
        notes.append(f"{path} holds initial curves only; these are drawn")
    return found[0]


def _scene_of(folder: Path, notes: list[str]) -> Scene | None:
    """The scene that a run's report names, None (and a note) where it is lost or broken."""
    if not (folder / REPORT).is_file():
        notes.append(f"{folder} holds no {REPORT}, so its scene is unknown: drawn without it")
        return None
    try:
        recorded = recorded_scene(folder)
        scene = load_scene(recorded.source, overrides=recorded.overrides)
    except (UsageError, SceneError) as error:
        reason = str(error).splitlines()[0].partition(";")[0]
        notes.append(f"drawn without the scene: {reason}")
        return None
    if recorded.content_hash not in (None, scene.content_hash):
        notes.append(f"{scene.source} is not as it was when this run was planned")
    return scene


def _title(name: str, file: Path) -> str:
    return f"{name}, initial curves" if file.stem == "seed" else name


def _sizes(file: Path, lines: WorldLines) -> tuple[FloatArray | None, float | None]:
    """Radii and time scale as they were when planned, from the .npz itself or beside the .csv."""
    source = file.with_suffix(".npz")
    if not source.is_file():
        return None, None
    content = read_npz(source)
    if content.world_lines.agent_ids != lines.agent_ids:
        return None, None
    return content.radii, content.time_scale


def _without_scene(
    file: Path,
    lines: WorldLines,
    seed: WorldLines | None,
    radii: FloatArray,
    time_scale: float | None,
    notes: tuple[str, ...],
) -> RunView:
    name = file.resolve().parent.name
    return RunView(
        name=name,
        title=_title(name, file),
        description="",
        crowd=Crowd.of_discs(lines, radii),
        seed=seed,
        waypoints=((),) * lines.num_agents,
        time_scale=1.0 if time_scale is None else time_scale,
        notes=notes,
    )
