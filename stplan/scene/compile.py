"""A validated file -> an immutable `Scene`, with every fault that only keys together can have.

Where a part of the file is not valid, the rest is still looked at, so that a user learns of all faults
at once: `Parts` holds None for what could not be read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

from stplan.scene.faults import Fault, Hints
from stplan.scene.format import AgentFile, MapFile, PairFile, SceneFile, SharedFields
from stplan.scene.maps import compile_map
from stplan.scene.model import (
    Agent,
    PairRule,
    Point,
    Scene,
    SeedingSettings,
    SolverSettings,
    Weights,
)
from stplan.scene.overlaps import overlap_faults
from stplan.scene.quantities import REFUSED_OPTIONS

DEFAULT_RADIUS = 0.3
DEFAULT_MASS = 1.0

_Model = TypeVar("_Model", bound=BaseModel)


@dataclass
class Parts:
    """What could be read of a file; None, or left out, where it could not."""

    ids: list[str | None]
    agents: list[AgentFile | None]
    pairs: list[PairFile | None]
    defaults: SharedFields | None
    horizon: float | None
    map: MapFile | None


def parts_of(file: SceneFile) -> Parts:
    """The parts of a file that is valid."""
    return Parts(
        [agent.id for agent in file.agents],
        list(file.agents),
        list(file.pairs),
        file.defaults,
        file.horizon,
        file.map,
    )


def salvage(tree: Mapping[str, Any], broken: set[str]) -> Parts:
    """The parts of a file that have no fault at or below them; `broken` are paths with faults."""
    tops = {_top(path) for path in broken}

    def read(model: type[_Model], path: str, value: Any) -> _Model | None:
        return None if path in tops or value is None else model.model_validate(value)

    agents = tree.get("agents")
    agents = agents if isinstance(agents, list) and "agents" not in tops else []
    pairs = tree.get("pairs")
    pairs = pairs if isinstance(pairs, list) and "pairs" not in tops else []
    defaults = read(SharedFields, "defaults", tree.get("defaults", {}))
    agents_fit = defaults is not None and "horizon" not in tops
    return Parts(
        [_id(entry) for entry in agents],
        [
            read(AgentFile, f"agents[{k}]", entry) if agents_fit else None
            for k, entry in enumerate(agents)
        ],
        [read(PairFile, f"pairs[{k}]", entry) for k, entry in enumerate(pairs)],
        defaults,
        None if "horizon" in tops else tree.get("horizon"),
        read(MapFile, "map", tree.get("map")),
    )


def _top(path: str) -> str:
    """``agents[2].weights.wall`` -> ``agents[2]``, ``map.mesh`` -> ``map``."""
    return path.partition(".")[0]


def _id(entry: Any) -> str | None:
    name = entry.get("id") if isinstance(entry, dict) else None
    return name if isinstance(name, str) else None


def check_parts(parts: Parts, directory: Path, hints: Hints) -> list[Fault]:
    """Every fault of the parts that were read, except those that need the whole scene."""
    faults: list[Fault] = []
    _agents(parts, faults)
    _pairs(parts, _indices(parts.ids, faults), faults, hints)
    if parts.map is not None:
        compile_map(parts.map, directory, faults)
    return faults


def compile_scene(
    file: SceneFile,
    default_name: str,
    source: Path | None,
    directory: Path,
    locations: Mapping[str, tuple[int, int]],
    overridden: Mapping[str, str],
    hints: Hints,
) -> tuple[Scene, list[Fault]]:
    """The scene, and (path, sentence) of every fault; with faults the scene must not be used."""
    faults: list[Fault] = []
    parts = parts_of(file)
    agents = _agents(parts, faults)
    pairs = _pairs(parts, _indices(parts.ids, faults), faults, hints)
    map_spec = None if file.map is None else compile_map(file.map, directory, faults)
    for name in file.solver.ipopt:
        if name in REFUSED_OPTIONS:
            faults.append((f"solver.ipopt.{name}", f"is refused: {REFUSED_OPTIONS[name]}"))
    scene = Scene(
        name=file.name or default_name,
        description=file.description,
        source=source,
        content_hash="",
        map=map_spec,
        horizon=max(agent.max_time for agent in agents) if file.horizon is None else file.horizon,
        time_scale=file.time_scale,
        agents=tuple(agents),
        pairs=pairs,
        seeding=SeedingSettings(**_settings(file.seeding)),
        solver=SolverSettings(**_settings(file.solver)),
        locations=locations,
        overridden=overridden,
    )
    # Places of agents that have faults themselves would only make followers of these.
    if not any(path.startswith(("agents", "pairs", "defaults")) for path, _ in faults):
        faults += overlap_faults(scene)
    return scene, faults


def _settings(part: BaseModel) -> dict[str, Any]:
    """Keys and values, words replaced by what they mean to the rest of the package."""
    meaning = {"auto": None, "inf": float("inf")}
    values = {key: getattr(part, key) for key in type(part).model_fields}
    return {
        key: meaning[value] if key != "method" and value in ("auto", "inf") else value
        for key, value in values.items()
    }


def _indices(ids: list[str | None], faults: list[Fault]) -> dict[str, int]:
    """Index by id, with a fault for every id that is taken."""
    seen: dict[str, int] = {}
    for k, name in enumerate(ids):
        if name is None:
            continue
        path = f"agents[{k}].id"
        if name == "all":
            faults.append((path, "is 'all', which means every agent; another id is expected"))
        elif name in seen:
            faults.append(
                (path, f"is '{name}', as is agents[{seen[name]}].id; unique ids are expected")
            )
        seen.setdefault(name, k)
    return seen


def _agents(parts: Parts, faults: list[Fault]) -> list[Agent]:
    """The agents whose entries and defaults could be read."""
    if parts.defaults is None:
        return []
    defaults = parts.defaults
    agents = [
        _Merge(defaults, entry, f"agents[{k}]", faults).agent(parts.horizon)
        for k, entry in enumerate(parts.agents)
        if entry is not None
    ]
    # A fault of the defaults shows at every agent, and is told once.
    faults[:] = dict.fromkeys(faults)
    return agents


def _point(values: list[float]) -> Point:
    return (values[0], values[1])


class _Merge:
    """One agent: its own keys over `defaults` over what the format promises."""

    def __init__(
        self, defaults: SharedFields, own: AgentFile, path: str, faults: list[Fault]
    ) -> None:
        self._defaults, self._own, self._path, self._faults = defaults, own, path, faults

    def _value(self, key: str, fallback: Any) -> Any:
        for part in (self._own, self._defaults):
            value = getattr(part, key)
            if value is not None:
                return value
        return fallback

    def _fault(self, key: str, text: str) -> None:
        """A fault of `key`, told where its value stands: with the agent, or in `defaults`."""
        here: Any = self._own
        for step in key.split("."):
            here = getattr(here, step, None)
        there: Any = self._defaults
        for step in key.split("."):
            there = getattr(there, step, None)
        owner = "defaults" if here is None and there is not None else self._path
        self._faults.append((f"{owner}.{key}", text))

    def agent(self, horizon: float | None) -> Agent:
        """The agent; with new faults it must not be used."""
        own = self._own
        path: tuple[tuple[float, float, float], ...] | None = None
        weights = self._weights()
        if own.path is not None:
            path = tuple((x, y, t) for x, y, t in own.path)
            self._check_path(path)
            start, goal = path[0][:2], path[-1][:2]
            start_time, max_time = path[0][2], path[-1][2]
            waypoints: tuple[Point, ...] = ()
        else:
            start, goal = self._end("start"), self._end("goal")
            start_time, max_time = self._times(horizon)
            waypoints = tuple(_point(point) for point in self._value("waypoints", []))
            self._check_preferred_time(weights, start_time, max_time)
        return Agent(
            id=own.id,
            start=start,
            goal=goal,
            start_time=start_time,
            max_time=max_time,
            preferred_time=self._value("preferred_time", None),
            radius=self._value("radius", DEFAULT_RADIUS),
            mass=self._value("mass", DEFAULT_MASS),
            after_arrival=self._value("after_arrival", "stay"),
            waypoints=waypoints,
            weights=weights,
            path=path,
        )

    def _weights(self) -> Weights:
        values: dict[str, Any] = {}
        for part in (self._defaults.weights, self._own.weights):
            for key in () if part is None else part.model_fields_set:
                value = getattr(part, key)
                values[key] = None if value == "auto" else value
        return Weights(**values)

    def _end(self, key: str) -> Point:
        value = getattr(self._own, key)
        if value is None:
            self._faults.append(
                (f"{self._path}.{key}", "is missing; a point [x, y] in m is expected, or a path")
            )
        return _point(value or [0.0, 0.0])

    def _times(self, horizon: float | None) -> tuple[float, float]:
        start_time: float = self._value("start_time", 0.0)
        max_time: float | None = self._value("max_time", horizon)
        if max_time is None:
            text = "is missing; a time in s is expected, or a max_time of every agent"
            self._faults.append(("horizon", text))
            return start_time, start_time + 1.0
        if max_time <= start_time:
            given = self._own.max_time is not None or self._defaults.max_time is not None
            key = "max_time" if given else "start_time"
            text = (
                f"max_time {max_time:g} s is not after start_time {start_time:g} s"
                if given
                else f"is {start_time:g} s; less than the horizon {max_time:g} s is expected"
            )
            self._fault(key, text + ("; a later one is expected" if given else ""))
        return start_time, max_time

    def _check_preferred_time(self, weights: Weights, start_time: float, max_time: float) -> None:
        preferred: float | None = self._value("preferred_time", None)
        if preferred is None:
            if weights.arrival > 0:
                self._fault(
                    "weights.arrival",
                    f"is {weights.arrival:g}, but preferred_time is missing; a time in s is expected",
                )
        elif not start_time < preferred <= max_time:
            self._fault(
                "preferred_time",
                f"is {preferred:g} s; after start_time {start_time:g} s and no later than "
                f"max_time {max_time:g} s is expected",
            )

    def _check_path(self, path: tuple[tuple[float, float, float], ...]) -> None:
        """Times of a given path rise, and what repeats it says the same."""
        own, here = self._own, self._path
        for k in range(1, len(path)):
            if path[k][2] <= path[k - 1][2]:
                text = f"is at {path[k][2]:g} s; later than the knot before is expected"
                self._faults.append((f"{here}.path[{k}][2]", f"{text} ({path[k - 1][2]:g} s)"))
        for key, place in (("start", path[0]), ("goal", path[-1])):
            value = getattr(own, key)
            if value is not None and _point(value) != place[:2]:
                text = f"is not the path's end ({place[0]:g}, {place[1]:g}); leave it out"
                self._faults.append((f"{here}.{key}", text))
        if own.start_time is not None and own.start_time != path[0][2]:
            text = f"is {own.start_time:g} s, the path starts at {path[0][2]:g} s; leave it out"
            self._faults.append((f"{here}.start_time", text))
        if own.max_time is not None and own.max_time < path[-1][2]:
            text = f"is {own.max_time:g} s, the path ends at {path[-1][2]:g} s; leave it out"
            self._faults.append((f"{here}.max_time", text))
        if own.waypoints:
            text = "belongs to agents that find their way; one with a path passes its knots"
            self._faults.append((f"{here}.waypoints", text))


def _pairs(
    parts: Parts, ids: dict[str, int], faults: list[Fault], hints: Hints
) -> tuple[PairRule, ...]:
    everyone = tuple(range(len(parts.ids)))
    # Of an agent whose id could not be read nothing is known, perhaps it is the one that is meant.
    all_known = None not in parts.ids
    rules = []
    for k, entry in enumerate(parts.pairs):
        if entry is None:
            continue
        sides: list[tuple[int, ...]] = []
        for s, side in enumerate(entry.between):
            names = side if isinstance(side, list) else [side]
            for name in names:
                if name != "all" and name not in ids and all_known:
                    hint = hints(name, ids)
                    faults.append((f"pairs[{k}].between[{s}]", f"there is no agent '{name}'{hint}"))
            members = dict.fromkeys(ids[name] for name in names if name in ids)
            sides.append(everyone if "all" in names else tuple(members))
        left, right = sides
        if len(left) == 1 and left == right:
            faults.append(
                (f"pairs[{k}].between", "is an agent and itself; two agents are expected")
            )
        if entry.distance is None and entry.grouping is None and entry.collide is None:
            faults.append(
                (f"pairs[{k}]", "changes nothing; distance, grouping or collide is expected")
            )
        rules.append(PairRule(left, right, entry.distance, entry.grouping, entry.collide))
    return tuple(rules)
