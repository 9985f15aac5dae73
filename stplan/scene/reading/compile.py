"""A validated file -> an immutable `Scene`, with every fault that only keys together can have.

Where a part of the file is not valid, the rest is still looked at, so that a user learns of all faults
at once: `Parts` holds None for what could not be read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, TypeAdapter

from stplan.maps.registry import MapFile, compile_map
from stplan.scene.format.agents import (
    MOST_AGENTS,
    AgentEntry,
    AgentFile,
    AgentsCsvFile,
    CrowdFile,
    PatternFile,
    SharedFields,
)
from stplan.scene.format.file import GroupFile, PairFile, SceneFile
from stplan.scene.format.places import PlaceFile, StartPlaceFile
from stplan.scene.model import Agent, Scene, SeedingSettings, SolverSettings
from stplan.scene.moving_goals import is_play
from stplan.scene.places import Assignment, Place
from stplan.scene.presets import PRESETS
from stplan.scene.reading.crowds import assigned_points
from stplan.scene.reading.draws import with_drawn_starts
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.haste import haste_faults, latest_time, with_long_horizon
from stplan.scene.reading.merge import merged_agent
from stplan.scene.reading.moving_goals import capture_faults, moving_faults, with_captures
from stplan.scene.reading.overlaps import overlap_faults
from stplan.scene.reading.pair_rules import Placed, group_rules, meeting_faults, pair_rules
from stplan.scene.reading.passing import passed_places, with_passed_points
from stplan.scene.reading.patterns import Listed, listed_agents, num_agents
from stplan.scene.reading.places import Places, compile_places
from stplan.scene.reading.residents import Residents
from stplan.scene.reading.robustness import robust_faults, with_robustness
from stplan.scene.reading.tasks import endless_faults, with_homes, with_some_goal, with_tasks
from stplan.schema.mapping import Fault
from stplan.schema.quantities import REFUSED_OPTIONS

_Model = TypeVar("_Model", bound=BaseModel)
# Where faults make it pointless to look whether agents are in each other's way.
SEEDING = SeedingSettings()
PLACED = ("agents", "groups", "pairs", "defaults", "places", "map")


@dataclass
class Parts:
    """What could be read of a file; None, or left out, where it could not."""

    ids: list[str | None]
    entries: list[AgentFile | PatternFile | AgentsCsvFile | None]
    groups: list[GroupFile | None]
    pairs: list[PairFile | None]
    defaults: SharedFields | None
    horizon: float | str | None
    map: MapFile | None
    places: Mapping[str, PlaceFile] | None
    rng_seed: int
    has_tasks: bool


def parts_of(file: SceneFile) -> Parts:
    """The parts of a file that is valid."""
    return Parts(
        [entry.id for entry in file.agents],
        list(file.agents),
        list(file.groups),
        list(file.pairs),
        file.defaults,
        file.horizon,
        file.map,
        file.places,
        file.seeding.rng_seed,
        file.tasks is not None,
    )


def salvage(tree: Mapping[str, Any], broken: set[str]) -> Parts:
    """The parts of a file that have no fault at or below them; `broken` are paths with faults."""
    tops = {_top(path) for path in broken}

    def read(model: type[_Model], path: str, value: Any) -> _Model | None:
        return None if path in tops or value is None else model.model_validate(value)

    def entries(key: str) -> list[Any]:
        value = tree.get(key)
        return value if isinstance(value, list) and key not in tops else []

    defaults = read(SharedFields, "defaults", tree.get("defaults", {}))
    agents_fit = defaults is not None and "horizon" not in tops
    agents = TypeAdapter(AgentEntry)
    return Parts(
        [_id(entry) for entry in entries("agents")],
        [
            agents.validate_python(entry)
            if agents_fit and f"agents[{k}]" not in tops and entry is not None
            else None
            for k, entry in enumerate(entries("agents"))
        ],
        [read(GroupFile, f"groups[{k}]", entry) for k, entry in enumerate(entries("groups"))],
        [read(PairFile, f"pairs[{k}]", entry) for k, entry in enumerate(entries("pairs"))],
        defaults,
        None if "horizon" in tops else tree.get("horizon"),
        read(MapFile, "map", tree.get("map")),
        _sound_places(tree.get("places", {}), broken),
        SEEDING.rng_seed,
        tree.get("tasks") is not None,
    )


def _sound_places(value: Any, broken: set[str]) -> Mapping[str, PlaceFile] | None:
    """The places of a file, None where one has a fault."""
    if not isinstance(value, dict) or any(path.startswith("places") for path in broken):
        return None
    return {name: PlaceFile.model_validate(entry) for name, entry in value.items()}


def _top(path: str) -> str:
    """``agents[2].weights.wall`` -> ``agents[2]``, ``map.mesh`` -> ``map``."""
    return path.partition(".")[0]


def _id(entry: Any) -> str | None:
    """An agent's id; of patterns and tables nobody knows whom they stand for."""
    single = isinstance(entry, dict) and not entry.keys() & {"pattern", "file", "count", "source"}
    name = entry.get("id") if single else None
    return name if isinstance(name, str) else None


def check_parts(parts: Parts, directory: Path, hints: Hints) -> list[Fault]:
    """Every fault of the parts that were read, except those that need the whole scene."""
    faults: list[Fault] = []
    listed = _listed(parts, directory, faults)
    places = _places(parts, faults)
    _agents(parts, listed, places, faults, hints)
    _rules(parts, listed, places, faults, hints)
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
    listed = _listed(parts, directory, faults)
    places = _places(parts, faults)
    agents = _agents(parts, listed, places, faults, hints)
    rules = _rules(parts, listed, places, faults, hints)
    map_spec = None if file.map is None else compile_map(file.map, directory, faults)
    for name in file.solver.ipopt:
        if name in REFUSED_OPTIONS:
            faults.append((f"solver.ipopt.{name}", f"is refused: {REFUSED_OPTIONS[name]}"))
    preset = None if file.preset is None else PRESETS[file.preset]
    time_scale = file.time_scale
    if preset is not None and "time_scale" not in file.model_fields_set:
        time_scale = preset.time_scale
    scene = Scene(
        name=file.name or default_name,
        description=file.description,
        source=source,
        content_hash="",
        map=map_spec,
        horizon=max((agent.max_time for agent in agents), default=1.0)
        if file.horizon is None
        else latest_time(file.horizon) or 1.0,
        replan_every=file.replan_every,
        horizon_rule="auto" if isinstance(file.horizon, str) else "stated",
        minimise=file.minimise,
        overlap=file.overlap,
        time_scale=1.0 if time_scale == "auto" else time_scale,
        metric="auto" if time_scale == "auto" else "stated",
        agents=tuple(agents),
        pairs=tuple(placed.rule for placed in rules),
        seeding=SeedingSettings(**_settings(file.seeding, preset.seeding if preset else {})),
        solver=SolverSettings(**_settings(file.solver, preset.solver if preset else {})),
        locations=locations,
        overridden=overridden,
        agent_paths=tuple(one.path for one in listed),
        places=tuple(places.known.values()),
        assignments=_assignments(parts, listed),
    )
    scene = with_long_horizon(with_robustness(scene, file.robust))
    faults += endless_faults(file)
    if file.tasks is not None and not faults:
        scene = with_tasks(scene, file.tasks, places, directory, faults, hints)
    if file.horizon != "none":
        faults += haste_faults(scene, file.defaults)
    faults += moving_faults(scene, file.defaults, hints)
    faults += robust_faults(scene)
    # Places of agents that have faults themselves would only make followers of these.
    if not any(path.startswith(PLACED) for path, _ in faults):
        full: list[Fault] = []
        scene = with_drawn_starts(scene, _drawn(listed, places, hints), full)
        scene = with_homes(scene, listed)
        scene = with_passed_points(
            scene, passed_places(listed, parts.defaults, places, hints), full
        )
        faults += full or overlap_faults(scene)
        faults += meeting_faults(scene, [rule.path for rule in rules])
    if is_play(scene) and not faults:
        faults += capture_faults(scene)
        scene = with_captures(scene)
    return scene, faults


def _places(parts: Parts, faults: list[Fault]) -> Places:
    """The places of the file that could be read."""
    if parts.places is None:
        return Places(complete=False)
    return compile_places(parts.places, faults)


def _drawn(listed: list[Listed], places: Places, hints: Hints) -> dict[int, Place]:
    """From which place the start of which agent is drawn."""
    drawn: dict[int, Place] = {}
    for a, one in enumerate(listed):
        start = None if one.agent is None else one.agent.start
        if isinstance(start, StartPlaceFile):
            for place in places.of_start(start, one.place("start"), [], hints):
                drawn[a] = place
    return drawn


def _assignments(parts: Parts, listed: list[Listed]) -> tuple[Assignment, ...]:
    """Crowds of which everybody gets one of some points."""
    found = []
    for k, entry in enumerate(parts.entries):
        points = assigned_points(entry) if isinstance(entry, CrowdFile) else []
        if points:
            members = tuple(a for a, one in enumerate(listed) if one.entry == f"agents[{k}]")
            found.append(Assignment(members, tuple((x, y) for x, y in points)))
    return tuple(found)


def _settings(part: BaseModel, preset: Mapping[str, Any]) -> dict[str, Any]:
    """Keys and values, words replaced by what they mean to the rest of the package.

    Keys that the file leaves out are as a `preset` has them.
    """
    meaning = {"auto": None, "inf": float("inf")}
    values = {key: getattr(part, key) for key in type(part).model_fields}
    said = {
        key: meaning[value] if key != "method" and value in ("auto", "inf") else value
        for key, value in values.items()
    }
    return said | {key: preset[key] for key in preset.keys() - part.model_fields_set}


def _listed(parts: Parts, directory: Path, faults: list[Fault]) -> list[Listed]:
    """Every agent of the file, those of patterns and tables among them."""
    found: list[Listed] = []
    total = 0
    for k, (name, entry) in enumerate(zip(parts.ids, parts.entries, strict=True)):
        path = f"agents[{k}]"
        if entry is None:
            found.append(Listed(name, None, path))
            total += 1
        elif total + num_agents(entry) > MOST_AGENTS:
            # Too many to be laid out; nothing is known about them.
            found.append(Listed(None, None, path))
            total += num_agents(entry)
        else:
            new = listed_agents(entry, path, directory, faults, parts.rng_seed)
            found += new
            total += len(new)
    if total > MOST_AGENTS:
        text = f"are {total}, patterns and tables included; at most {MOST_AGENTS} are expected"
        faults.append(("agents", text))
    return found


def _names(parts: Parts, listed: list[Listed], faults: list[Fault]) -> dict[str, tuple[int, ...]]:
    """Indices of the agents that every id stands for, with a fault for every id that is taken."""
    seen: dict[str, str] = {}
    names: dict[str, tuple[int, ...]] = {}
    collective: dict[str, list[int]] = {}
    for a, one in enumerate(listed):
        if one.entry:
            collective.setdefault(one.entry, []).append(a)
    entries = [
        (name, f"agents[{k}]", tuple(collective[f"agents[{k}]"]))
        for k, name in enumerate(parts.ids)
        if f"agents[{k}]" in collective
    ]
    singles = [(one.id, one.path, (a,)) for a, one in enumerate(listed)]
    for name, path, members in singles + entries:
        if name is None:
            continue
        if name == "all":
            text = "is 'all', which means every agent; another id is expected"
            faults.append((f"{path}.id", text))
        elif name in names:
            text = f"is '{name}', as is {seen[name]}.id; unique ids are expected"
            faults.append((f"{path}.id", text))
        if name not in names:
            seen[name], names[name] = path, members
    return names


def _agents(
    parts: Parts, listed: list[Listed], places: Places, faults: list[Fault], hints: Hints
) -> list[Agent]:
    """The agents whose entries and defaults could be read."""
    if parts.defaults is None:
        return []
    horizon = latest_time(parts.horizon)
    agents = [
        merged_agent(parts.defaults, with_some_goal(one.agent), one, horizon, places, faults, hints)
        if parts.has_tasks
        else merged_agent(parts.defaults, one.agent, one, horizon, places, faults, hints)
        for one in listed
        if one.agent is not None
    ]
    # A fault of the defaults shows at every agent, and is told once.
    faults[:] = dict.fromkeys(faults)
    return agents


def _rules(
    parts: Parts, listed: list[Listed], places: Places, faults: list[Fault], hints: Hints
) -> list[Placed]:
    """What groups and pairs say, in this order."""
    names = _names(parts, listed, faults)
    known = all(
        entry is not None or name is not None
        for name, entry in zip(parts.ids, parts.entries, strict=True)
    )
    rules = group_rules(parts.groups, names, known, faults, hints)
    residents = Residents(listed, places)
    return rules + pair_rules(parts.pairs, names, len(listed), known, faults, hints, residents)
