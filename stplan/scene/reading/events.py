"""Events of a file -> changes: every world that there will be, read like a scene of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

from stplan.errors import SceneError
from stplan.scene.format.events import EventFile
from stplan.scene.model import Scene, WorldChange
from stplan.scene.moving_goals import is_play
from stplan.scene.reading.overrides import set_value
from stplan.schema.mapping import Fault

# What of a scene may become different, and what else an event says.
CHANGEABLE = ("agents", "defaults", "map", "places", "groups", "pairs", "horizon")
KINDS = ("agent", "add", "remove", "obstacle", "set")
OF_AGENTS = ("goal", "delay", "max_speed")

# From the tree of a world to its scene, and what is wrong with it.
Read = Callable[[Any], tuple[Scene | None, list[Fault]]]


@dataclass
class _Moment:
    """What happens at one time: edits of the tree, and what is said of them."""

    edits: list[Callable[[dict[str, Any]], None]] = field(default_factory=list)
    concerned: set[str] = field(default_factory=set)
    removed: set[str] = field(default_factory=set)
    delays: list[tuple[str, float]] = field(default_factory=list)
    causes: list[str] = field(default_factory=list)
    path: str = ""


def compile_events(
    events: Sequence[EventFile], tree: dict[str, Any], scene: Scene, read: Read
) -> tuple[tuple[WorldChange, ...], list[Fault]]:
    """The changes of `scene`, and every fault; with faults they must not be used.

    Args:
        tree: the scene's, as it was read.
        read: a tree without events.
    """
    faults: list[Fault] = []
    moments: dict[float, _Moment] = {}
    begin = min(agent.start_time for agent in scene.agents)
    for k, event in enumerate(events):
        path = f"events[{k}]"
        if not begin < event.at < scene.final_time:
            text = f"is {event.at:g} s; a time between {begin:g} s and {scene.final_time:g} s is expected"
            faults.append((f"{path}.at", text))
        faults += _misfits(event, path)
    if faults:
        return (), faults
    if scene.minimise != "energy" or scene.horizon_rule == "auto":
        text = "need a horizon that is stated, and go with `minimise: energy` alone"
        return (), [("events", text)]
    if is_play(scene):
        return (), [("events", "do not go together with goals that move, perception or tasks")]
    plain = [deepcopy(entry) for entry in tree.get("events", [])]
    for k, event in enumerate(events):
        moment = moments.setdefault(event.at, _Moment(path=f"events[{k}]"))
        _enter(event, plain[k], moment, moments)
    world = deepcopy({name: value for name, value in tree.items() if name != "events"})
    known = {agent.id for agent in scene.agents}
    removed: set[str] = set()
    changes = []
    for at in sorted(moments):
        moment = moments[at]
        try:
            for edit in moment.edits:
                edit(world)
        except SceneError as error:
            return (), [(moment.path, "; ".join(error.messages))]
        later, wrong = read(deepcopy(world))
        if later is None or wrong:
            return (), [(moment.path, f"{path}: {text}") for path, text in wrong]
        faults += [
            (moment.path, f"{name!r} was taken away before")
            for name in sorted(moment.concerned & removed)
        ]
        removed |= moment.removed
        faults += _unfit(later, known, moment, at)
        known |= {agent.id for agent in later.agents}
        changes.append(
            WorldChange(at, later, frozenset(removed), tuple(moment.delays), tuple(moment.causes))
        )
    return tuple(changes), faults


def _misfits(event: EventFile, path: str) -> list[Fault]:
    """Keys of one event that do not go together."""
    given = [name for name in KINDS if getattr(event, name) is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        return [(path, f"has {found} of {', '.join(KINDS[:-1])} and {KINDS[-1]}; one is expected")]
    of_agent = [name for name in OF_AGENTS if getattr(event, name) is not None]
    if given == ["agent"] and len(of_agent) != 1:
        found = " and ".join(of_agent) or "none"
        return [(path, f"has {found} of goal, delay and max_speed; one is expected")]
    faults: list[Fault] = []
    if given != ["agent"]:
        faults += [
            (f"{path}.{name}", "belongs to an agent, and there is none") for name in of_agent
        ]
    if event.until is not None:
        if event.obstacle is None:
            faults.append((f"{path}.until", "belongs to an obstacle, and there is none"))
        elif event.until <= event.at:
            faults.append(
                (f"{path}.until", f"is {event.until:g} s; later than {event.at:g} s is expected")
            )
    for name in event.set or {}:
        if name.partition(".")[0].partition("[")[0] not in CHANGEABLE:
            faults.append((f"{path}.set", f"{name!r} does not change on the way; {_CHOICES} do"))
    return faults


_CHOICES = f"{', '.join(CHANGEABLE[:-1])} and {CHANGEABLE[-1]}"


def _unfit(scene: Scene, known: set[str], moment: _Moment, at: float) -> list[Fault]:
    """What of a moment does not fit its world."""
    names = {agent.id: agent for agent in scene.agents}
    faults: list[Fault] = [
        (moment.path, f"there is no agent {name!r}")
        for name in sorted(moment.removed | {name for name, _ in moment.delays})
        if name not in names
    ]
    faults += [
        (moment.path, f"{agent.id!r} starts at {agent.start_time:g} s, before it is added")
        for agent in scene.agents
        if agent.id not in known and agent.start_time < at
    ]
    faults += [
        (moment.path, f"{name!r} moves on a path; only agents that find their way are delayed")
        for name, _ in moment.delays
        if name in names and names[name].path is not None
    ]
    if is_play(scene):
        faults.append(
            (moment.path, "events and goals that move, or perception, do not go together")
        )
    if any(rule.meet for rule in scene.pairs):
        faults.append((moment.path, "events and pairs that meet do not go together"))
    return faults


def _enter(
    event: EventFile, plain: dict[str, Any], moment: _Moment, moments: dict[float, _Moment]
) -> None:
    """Note in `moment` what an event does; obstacles that go do so in a moment of their own."""
    cause = ""
    moment.concerned |= {name for name in (event.agent, event.remove) if name is not None}
    if event.agent is not None:
        name = event.agent
        if event.delay is not None:
            moment.delays.append((name, event.delay))
            cause = f"{name} stands still for {event.delay:g} s"
        elif event.goal is not None:
            moment.edits.append(
                lambda tree: _set_agent(tree, name, goal=plain["goal"], waypoints=[])
            )
            cause = f"{name} gets another goal"
        else:
            moment.edits.append(lambda tree: _set_agent(tree, name, max_speed=plain["max_speed"]))
            cause = f"{name} goes {event.max_speed:g} m/s at most"
    elif event.add is not None:
        agent = {"start_time": event.at} | plain["add"]
        moment.edits.append(lambda tree: tree["agents"].append(deepcopy(agent)))
        cause = f"{event.add.id} appears"
    elif event.remove is not None:
        moment.removed.add(event.remove)
        cause = f"{event.remove} is taken away"
    elif event.obstacle is not None:
        shape = plain["obstacle"]
        moment.edits.append(lambda tree: _obstacles(tree).append(shape))
        cause = "something is in the way"
        if event.until is not None:
            end = moments.setdefault(event.until, _Moment(path=moment.path))
            end.edits.append(lambda tree: _remove(_obstacles(tree), shape))
            end.causes.append(
                f"no longer: {event.because}" if event.because else "it is out of the way again"
            )
    else:
        given = plain["set"]
        moment.edits.append(lambda tree: _set_all(tree, given))
        cause = f"{' and '.join(given)} changed"
    moment.causes.append(event.because or cause)


def _set_agent(tree: dict[str, Any], name: str, **values: Any) -> None:
    for key, value in values.items():
        set_value(tree, f"agents.{name}.{key}", deepcopy(value))


def _set_all(tree: dict[str, Any], given: dict[str, Any]) -> None:
    for key, value in given.items():
        set_value(tree, key, deepcopy(value))


def _obstacles(tree: dict[str, Any]) -> list[Any]:
    if not isinstance(tree.get("map"), dict):
        raise SceneError("an obstacle needs a map to be cut out of, and there is none")
    found: list[Any] = tree["map"].setdefault("obstacles", [])
    return found


def _remove(obstacles: list[Any], shape: Any) -> None:
    obstacles[:] = [one for one in obstacles if one is not shape]
