"""A validated file -> an immutable `Scene`, with every fault that only keys together can have."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from stplan.scene.faults import did_you_mean
from stplan.scene.format import AgentFile, MapFile, ObstacleFile, SceneFile, SharedFields
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import (
    Agent,
    CircleObstacle,
    MapSpec,
    MeshBase,
    PairRule,
    Point,
    PolygonBase,
    PolygonObstacle,
    Scene,
    SeedingSettings,
    SolverSettings,
    Weights,
)

DEFAULT_RADIUS = 0.3
DEFAULT_MASS = 1.0
MESH_SUFFIXES = (".obj", ".ply", ".off", ".stl", ".glb")
LARGEST_MESH = 200 * 1024 * 1024

Fault = tuple[str, str]


def compile_scene(
    file: SceneFile,
    default_name: str,
    source: Path | None,
    directory: Path,
    locations: Mapping[str, tuple[int, int]],
) -> tuple[Scene, list[Fault]]:
    """The scene, and (path, sentence) of every fault; with faults the scene must not be used."""
    faults: list[Fault] = []
    agents = [_agent(file, entry, k, faults) for k, entry in enumerate(file.agents)]
    seen: dict[str, int] = {}
    for k, agent in enumerate(agents):
        if agent.id == "all":
            faults.append((f"agents[{k}].id", "'all' means every agent; another id is expected"))
        if agent.id in seen:
            faults.append(
                (f"agents[{k}].id", f"'{agent.id}' is also the id of agents[{seen[agent.id]}]")
            )
        seen.setdefault(agent.id, k)
    settings = file.solver.model_dump()
    horizon = file.horizon
    if horizon is None:
        horizon = max(agent.max_time for agent in agents)
    scene = Scene(
        name=file.name or default_name,
        description=file.description,
        source=source,
        content_hash="",
        map=None if file.map is None else _map(file.map, directory, faults),
        horizon=horizon,
        time_scale=file.time_scale,
        agents=tuple(agents),
        pairs=_pairs(file, seen, faults),
        seeding=SeedingSettings(**file.seeding.model_dump()),
        solver=SolverSettings(**settings),
        locations=locations,
    )
    if not faults:
        faults += _overlaps(scene)
    return scene, faults


def _merged(defaults: SharedFields, own: AgentFile, key: str, fallback: Any) -> Any:
    value = getattr(own, key)
    if value is None:
        value = getattr(defaults, key)
    return fallback if value is None else value


def _weights(defaults: SharedFields, own: AgentFile) -> Weights:
    values: dict[str, Any] = {}
    for part in (defaults.weights, own.weights):
        if part is not None:
            values |= {key: getattr(part, key) for key in part.model_fields_set}
    kept = {key: value for key, value in values.items() if value is not None}
    return Weights(**kept)


def _point(values: list[float]) -> Point:
    return (float(values[0]), float(values[1]))


def _agent(file: SceneFile, entry: AgentFile, index: int, faults: list[Fault]) -> Agent:
    here = f"agents[{index}]"
    path = (
        None
        if entry.path is None
        else tuple((float(x), float(y), float(t)) for x, y, t in entry.path)
    )
    start, goal = entry.start, entry.goal
    start_time = float(_merged(file.defaults, entry, "start_time", 0.0))
    max_time = _merged(file.defaults, entry, "max_time", file.horizon)
    if path is not None:
        _check_path(entry, path, here, faults)
        start, goal = list(path[0][:2]), list(path[-1][:2])
        start_time, max_time = path[0][2], path[-1][2]
    for key, value in (("start", start), ("goal", goal)):
        if value is None:
            faults.append((f"{here}.{key}", "is missing"))
    if max_time is None:
        faults.append((here, "has no max_time and the scene no horizon; one of them is expected"))
        max_time = start_time + 1.0
    max_time = float(max_time)
    if max_time <= start_time:
        faults.append(
            (
                f"{here}.max_time",
                f"is {max_time:g} s; later than start_time {start_time:g} s is expected",
            )
        )
    weights = _weights(file.defaults, entry)
    preferred = _merged(file.defaults, entry, "preferred_time", None)
    if weights.arrival > 0 and preferred is None:
        faults.append((f"{here}.weights.arrival", "needs a preferred_time"))
    if preferred is not None and not start_time < preferred <= max_time:
        faults.append(
            (
                f"{here}.preferred_time",
                f"is {preferred:g} s; after start_time {start_time:g} s and no later than "
                f"max_time {max_time:g} s is expected",
            )
        )
    return Agent(
        id=entry.id,
        start=_point(start or [0.0, 0.0]),
        goal=_point(goal or [0.0, 0.0]),
        start_time=start_time,
        max_time=max_time,
        preferred_time=None if preferred is None else float(preferred),
        radius=float(_merged(file.defaults, entry, "radius", DEFAULT_RADIUS)),
        mass=float(_merged(file.defaults, entry, "mass", DEFAULT_MASS)),
        after_arrival=_merged(file.defaults, entry, "after_arrival", "stay"),
        waypoints=()
        if path is not None
        else tuple(_point(p) for p in _merged(file.defaults, entry, "waypoints", [])),
        weights=weights,
        path=path,
    )


def _check_path(
    entry: AgentFile, path: tuple[tuple[float, float, float], ...], here: str, faults: list[Fault]
) -> None:
    """Times of a given path rise, and what repeats it says the same."""
    for k in range(1, len(path)):
        if path[k][2] <= path[k - 1][2]:
            faults.append((f"{here}.path[{k}]", "is no later than the knot before it"))
    given = {"start": path[0][:2], "goal": path[-1][:2]}
    for key, place in given.items():
        value = getattr(entry, key)
        if value is not None and _point(value) != place:
            faults.append((f"{here}.{key}", f"differs from the path's {place}"))
    if entry.start_time is not None and entry.start_time != path[0][2]:
        faults.append((f"{here}.start_time", f"differs from the path's {path[0][2]:g} s"))
    if entry.waypoints:
        faults.append((f"{here}.waypoints", "an agent with a path has no waypoints"))


def _pairs(file: SceneFile, ids: dict[str, int], faults: list[Fault]) -> tuple[PairRule, ...]:
    everyone = tuple(range(len(file.agents)))
    rules = []
    for k, entry in enumerate(file.pairs):
        sides: list[tuple[int, ...]] = []
        for s, side in enumerate(entry.between):
            members: list[int] = []
            for name in side if isinstance(side, list) else [side]:
                if name == "all":
                    members += everyone
                elif name in ids:
                    members.append(ids[name])
                else:
                    faults.append(
                        (
                            f"pairs[{k}].between[{s}]",
                            f"there is no agent '{name}'{did_you_mean(name, ids)}",
                        )
                    )
            sides.append(tuple(dict.fromkeys(members)))
        if entry.distance is None and entry.grouping is None and entry.collide is None:
            faults.append(
                (f"pairs[{k}]", "says nothing; distance, grouping or collide is expected")
            )
        rules.append(PairRule(sides[0], sides[1], entry.distance, entry.grouping, entry.collide))
    return tuple(rules)


def _map(entry: MapFile, directory: Path, faults: list[Fault]) -> MapSpec:
    given = [key for key in ("mesh", "polygon", "rectangle") if getattr(entry, key) is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        faults.append(
            ("map", f"has {found}; exactly one of mesh, polygon and rectangle is expected")
        )
    if entry.holes is not None and entry.polygon is None:
        faults.append(("map.holes", "belong to a polygon; use obstacles with other maps"))
    if entry.up is not None and entry.mesh is None:
        faults.append(("map.up", "belongs to a mesh"))
    base: MeshBase | PolygonBase
    if entry.mesh is not None:
        base = MeshBase(_mesh_path(entry.mesh, directory, faults), _up(entry))
    elif entry.polygon is not None:
        outer = _ring(entry.polygon, "map.polygon", faults)
        holes = [_ring(hole, f"map.holes[{k}]", faults) for k, hole in enumerate(entry.holes or [])]
        base = PolygonBase(outer, tuple(holes))
        if not faults:
            _check_holes(base, faults)
    else:
        base = PolygonBase(_rectangle(entry.rectangle or [0, 0, 1, 1], "map.rectangle", faults))
    obstacles = tuple(
        _obstacle(obstacle, f"map.obstacles[{k}]", faults)
        for k, obstacle in enumerate(entry.obstacles or [])
    )
    return MapSpec(base, obstacles, entry.resolution)


def _up(entry: MapFile) -> Literal["x", "y", "z"]:
    return entry.up or "z"


def _mesh_path(text: str, directory: Path, faults: list[Fault]) -> Path:
    path = directory / text
    try:
        if "\x00" in text or not path.is_file():
            faults.append(("map.mesh", f"there is no file {text!r} beside the scene"))
        elif path.suffix.lower() not in MESH_SUFFIXES:
            faults.append(
                ("map.mesh", f"is {text!r}; one of {', '.join(MESH_SUFFIXES)} is expected")
            )
        elif path.stat().st_size > LARGEST_MESH:
            faults.append(("map.mesh", f"is larger than {LARGEST_MESH // 2**20} MiB"))
    except OSError as error:
        faults.append(("map.mesh", f"cannot be read: {error.strerror}"))
    return path


def _rectangle(values: list[float], path: str, faults: list[Fault]) -> tuple[Point, ...]:
    x0, y0, x1, y1 = (float(value) for value in values)
    if x0 >= x1 or y0 >= y1:
        faults.append((path, "has no area; [xmin, ymin, xmax, ymax] with xmin < xmax, ymin < ymax"))
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def _ring(points: list[list[float]], path: str, faults: list[Fault]) -> tuple[Point, ...]:
    import shapely

    ring = tuple(_point(point) for point in points)
    shape = shapely.Polygon(ring)
    if not shape.is_valid:
        faults.append((path, f"is no simple ring: {shapely.is_valid_reason(shape)}"))
    elif shape.area == 0:
        faults.append((path, "has no area"))
    return ring


def _check_holes(base: PolygonBase, faults: list[Fault]) -> None:
    import shapely

    shape = shapely.Polygon(base.outer, base.holes)
    if not shape.is_valid:
        faults.append(("map.holes", f"do not fit the polygon: {shapely.is_valid_reason(shape)}"))


def _obstacle(
    entry: ObstacleFile, path: str, faults: list[Fault]
) -> PolygonObstacle | CircleObstacle:
    given = [key for key in ("rectangle", "polygon", "circle") if getattr(entry, key) is not None]
    if len(given) != 1:
        faults.append((path, "exactly one of rectangle, polygon and circle is expected"))
    if entry.circle is not None:
        return CircleObstacle(_point(entry.circle.center), float(entry.circle.radius))
    if entry.polygon is not None:
        return PolygonObstacle(_ring(entry.polygon, f"{path}.polygon", faults))
    return PolygonObstacle(_rectangle(entry.rectangle or [0, 0, 1, 1], f"{path}.rectangle", faults))


def _overlaps(scene: Scene) -> list[Fault]:
    """Agents that touch where neither can move: at starts of one time, at goals they stay on."""
    interactions = scene_interactions(scene)
    faults: list[Fault] = []
    times = np.array([agent.start_time for agent in scene.agents])
    stays = np.array([agent.after_arrival == "stay" for agent in scene.agents])
    for key, together in (
        ("start", times[:, None] == times[None, :]),
        ("goal", stays[:, None] & stays[None, :]),
    ):
        points = np.array([getattr(agent, key) for agent in scene.agents])
        gap = np.hypot(*(points[:, None, :] - points[None, :, :]).transpose(2, 0, 1))
        close = together & interactions.collides & (gap <= interactions.distance)
        for a, b in zip(*np.nonzero(np.triu(close)), strict=True):
            faults.append(
                (
                    f"agents[{b}].{key}",
                    f"is {gap[a, b]:.4g} m from that of '{scene.agents[a].id}'; more than "
                    f"{interactions.distance[a, b]:.4g} m is expected of agents that collide",
                )
            )
    return faults
