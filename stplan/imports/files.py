"""Files of other programs -> a draft of a scene."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import shapely

from stplan.analysis.paths import path_length
from stplan.errors import UsageError
from stplan.imports.draft import SceneDraft, free_space_of, identifiers, scene_name
from stplan.imports.people import RADIUS, CrowdOptions, ReadFiles, people
from stplan.maps.files import LARGEST_FILE, FileContent
from stplan.maps.formats.base import located, open_file
from stplan.maps.formats.drawing import (
    Drawing,
    DrawnAgent,
    FileOptions,
    FormatError,
    bounds_of,
    moved,
)
from stplan.maps.formats.registry import SUFFIXES
from stplan.maps.mesh.base import SUFFIXES as MESHES
from stplan.maps.reader import MapError
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene import parse_scene
from stplan.seeding.elastic_bands.geodesics import geodesic_curves
from stplan.world import fitted_free_space

# The horizon gives the furthest agent so many times what its way takes alone at this speed, m/s (cells/s on
# grids of large cells).
SPEED, SLACK = 1.0, 1.5
LEAST_HORIZON = 10.0


def draft_of_files(
    paths: Sequence[Path], options: FileOptions, crowd: CrowdOptions, folder: Path, comment: str
) -> tuple[SceneDraft, list[str]]:
    """A draft of the scene that files describe, and what its user should know.

    Args:
        paths: one with a map, others with agents or goals for it.
        folder: where the scene will be; paths in it are relative to there.
        comment: how it was made.

    Raises:
        UsageError: there are no agents, or they do not fit.
        SceneError: a file cannot be used.
    """
    read = _read(paths, options)
    if read.map_file is None and not read.drawing.agents:
        raise UsageError(f"{paths[0]}: holds neither a map nor agents")
    tree: dict[str, Any] = {}
    free_space = None
    if read.map_file is not None:
        tree = map_keys(read.map_file, options, folder)
        if read.obstacles:
            rings = [shapely.get_coordinates(one.exterior)[:-1].tolist() for one in read.obstacles]
            tree["obstacles"] = [{"polygon": ring} for ring in rings]
        free_space, notes = free_space_of(tree, folder)
        read.notes += [f"{read.map_file.name} {note}" for note in notes]
    agents = people(read, free_space, crowd)
    if not agents and read.map_file is None:
        raise UsageError(f"{paths[0]}: holds no map to place agents on; name the map's file, too")
    if not agents:
        raise UsageError(f"{paths[0]}: carries no agents; --agents N places some at random")
    draft = SceneDraft(
        scene_name(paths[0].name.partition(".")[0]),
        (comment,),
        tree,
        crowd.horizon,
        {"radius": _common_radius(agents)},
        tuple(_keys(agent, name, agents) for agent, name in zip(agents, _ids(agents), strict=True)),
        _friendships(agents),
    )
    if draft.horizon is None and any(agent.max_time is None for agent in agents):
        draft = _with_horizon(draft, agents, read.drawing.grid, folder)
    return draft, read.notes


def _read(paths: Sequence[Path], options: FileOptions) -> ReadFiles:
    """All drawings, moved as the one with the map is."""
    drawings: list[tuple[Path, Drawing]] = []
    for path in paths:
        if path.suffix.lower() in MESHES:
            drawings.append((path, Drawing(margin=0.0)))
            continue
        drawings.append((path, _drawing(path, options)))
        (*_, name) = drawings[-1][1].names or ("",)
        beside = path.parent / name
        if path.suffix.lower() == ".scen" and len(paths) == 1 and name and beside.is_file():
            drawings.insert(0, (beside, _drawing(beside, options)))
    maps = [k for k, (_, one) in enumerate(drawings) if one.has_map or one.margin is not None]
    floors = [k for k in maps if drawings[k][1].floors or drawings[k][1].margin is not None]
    if len(floors) == 1:
        # Others may add obstacles to its floor.
        maps = floors + [k for k in maps if k not in floors and drawings[k][1].walls]
    if len(maps) > 1:
        named = ", ".join(str(drawings[k][0]) for k in maps)
        raise UsageError(f"{named}: several maps; one with the agents for it is expected")
    base = drawings[maps[0]][1] if maps else drawings[0][1]
    others = [one for _, one in drawings if one is not base]
    merged = base
    for other in others:
        merged = _joined(merged, other)
    box = bounds_of(base)
    more = Drawing(
        blocked=tuple(shape for other in others for shape in other.blocked), unit=base.unit
    )
    return ReadFiles(
        moved(merged, options, box),
        drawings[maps[0]][0] if maps else None,
        moved(more, options, box).blocked,
    )


def _joined(base: Drawing, other: Drawing) -> Drawing:
    """A map with the agents and regions of another file."""
    if any(agent.start[1] < 0 for agent in other.agents) and other.grid and base.height is not None:
        other = _raised(other, base.height)
    return replace(
        base,
        agents=base.agents + other.agents,
        flows=base.flows + other.flows,
        regions={**base.regions, **other.regions},
        spots={**base.spots, **other.spots},
        grid=base.grid or other.grid,
    )


def _raised(drawing: Drawing, height: float) -> Drawing:
    """Agents whose rows count down from zero, counted down from the top of a map."""

    def up(agent: DrawnAgent) -> DrawnAgent:
        x, y = agent.start
        goal = None if agent.goal is None else (agent.goal[0], agent.goal[1] + height)
        return replace(agent, start=(x, y + height), goal=goal)

    return replace(drawing, agents=tuple(up(agent) for agent in drawing.agents))


def _drawing(path: Path, options: FileOptions) -> Drawing:
    """What a file holds, in its own units."""
    if not path.is_file():
        raise UsageError(f"cannot read {path}: no such file")
    if path.suffix.lower() not in SUFFIXES:
        known = ", ".join(SUFFIXES + MESHES)
        raise UsageError(f"{path}: expected a name that ends in {known}")
    if path.stat().st_size > LARGEST_FILE:
        raise UsageError(f"{path}: is larger than {LARGEST_FILE // 2**20} MiB")
    file = FileContent(path, path.read_bytes())
    try:
        return open_file(file, options).raw_drawing()
    except MapError as error:
        raise UsageError(f"{path.parent / error.text}") from error
    except FormatError as error:
        raise UsageError(f"{path.parent / located(file, error)}") from error


def map_keys(file: Path, options: FileOptions, folder: Path) -> dict[str, Any]:
    """Keys of the scene's map."""
    shown = os.path.relpath(file, folder).replace(os.sep, "/")
    if file.suffix.lower() in MESHES:
        return {"mesh": shown}
    tree: dict[str, Any] = {"file": shown}
    for name in ("scale", "simplify", "weld", "thickness", "threshold", "level"):
        value = getattr(options, name)
        if value is not None:
            tree[name] = value
    for name in ("layers", "floor"):
        if getattr(options, name):
            tree[name] = list(getattr(options, name))
    if options.flip:
        tree["flip"] = options.flip
    if options.origin != (0.0, 0.0):
        tree["origin"] = list(options.origin)
    if not options.doors:
        tree["doors"] = "closed"
    return tree


def _with_horizon(
    draft: SceneDraft, agents: list[DrawnAgent], grid: float | None, folder: Path
) -> SceneDraft:
    """The draft with time enough for everybody to go the way that each would go alone."""
    scene = parse_scene(replace(draft, horizon=LEAST_HORIZON).text(), directory=folder)
    problem = PlanningProblem.from_scene(scene, fitted_free_space(scene))
    ways = geodesic_curves(problem)
    pace = SPEED * (grid if grid and grid >= 1 else 1.0)
    needed = [
        path_length(way) / min(pace, agent.max_speed or pace)
        for agent, way in zip(agents, ways, strict=True)
        if way is not None
    ]
    return replace(
        draft, horizon=float(max(LEAST_HORIZON, math.ceil(SLACK * max(needed, default=0.0))))
    )


def _common_radius(agents: list[DrawnAgent]) -> float:
    sizes = [agent.radius or RADIUS for agent in agents]
    return max(dict.fromkeys(sizes), key=sizes.count)


def _ids(agents: list[DrawnAgent]) -> list[str]:
    return identifiers([agent.id for agent in agents])


def _keys(agent: DrawnAgent, name: str, agents: list[DrawnAgent]) -> dict[str, Any]:
    """An agent's keys, those left out that are as everybody's."""
    keys: dict[str, Any] = {"id": name, "start": list(agent.start), "goal": list(agent.goal or ())}
    if agent.radius is not None and agent.radius != _common_radius(agents):
        keys["radius"] = agent.radius
    for key, value, default in (
        ("start_time", agent.start_time, 0.0), ("max_time", agent.max_time, None),
        ("max_speed", agent.max_speed, None), ("mass", agent.mass, 1.0),
    ):  # fmt: skip
        if value is not None and value != default:
            keys[key] = value
    if agent.vanishes:
        keys["after_arrival"] = "vanish"
    weights = dict(agent.weights)
    if weights.get("arrival") and agent.max_time is not None:
        keys["preferred_time"] = agent.max_time
    if weights:
        keys["weights"] = weights
    return keys


def _friendships(agents: list[DrawnAgent]) -> tuple[dict[str, Any], ...]:
    """Friends are drawn together."""
    names = dict(zip((agent.id for agent in agents), _ids(agents), strict=True))
    pairs = {
        tuple(sorted((names[agent.id], names[friend])))
        for agent in agents
        for friend in agent.friends
        if friend in names and friend != agent.id
    }
    return tuple({"between": list(pair), "grouping": 1.0} for pair in sorted(pairs))
