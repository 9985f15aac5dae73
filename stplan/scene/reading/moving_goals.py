"""Goals that move in a file: names are looked up, and what does not go together with them is said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stplan.amounts import distinct
from stplan.arrays import FloatArray
from stplan.scene.format.agents import SharedFields
from stplan.scene.format.moving_goals import KINDS, MovingGoalFile
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Agent, Scene
from stplan.scene.moving_goals import REPLAN_EVERY, MovingGoal, captures, is_play
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.places import Places
from stplan.schema.mapping import Fault

# Who is caught is so near, by default, as a multiple of the distance that the two keep.
CAPTURE = 1.5
# What is not planned once for all.
PLAYED = "a scene with goals that move, perception or tasks"
# Sums of radii that differ by this share are the same.
ROUNDING = 1e-9
_BELONGS = {"within": "follow", "capture": "pursue", "places": "evade"}


def moving_goal(
    entry: MovingGoalFile, path: str, places: Places, faults: list[Fault], hints: Hints
) -> MovingGoal | None:
    """The goal of an `entry`; None with new faults. A capture that is left out is 0 until `with_captures`."""
    given = [kind for kind in KINDS if getattr(entry, kind) is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        faults.append((path, f"has {found} of follow, pursue and evade; one is expected"))
        return None
    (kind,) = given
    wrong = [
        (f"{path}.{name}", f"belongs to {owner}, and this is {kind}")
        for name, owner in _BELONGS.items()
        if getattr(entry, name) is not None and owner != kind
    ]
    if kind == "follow" and entry.within is None:
        wrong.append((f"{path}.within", "is missing; a distance in m is expected"))
    names = [
        places.named(name, f"{path}.places[{k}]", wrong, hints)
        for k, name in enumerate(entry.places or [])
    ]
    if wrong:
        faults += wrong
        return None
    others = getattr(entry, kind)
    return MovingGoal(
        kind,  # type: ignore[arg-type]
        tuple(dict.fromkeys([others] if isinstance(others, str) else others)),
        entry.within or 0.0,
        entry.capture or 0.0,
        tuple(place for place in names if place is not None),
    )


def with_captures(scene: Scene) -> Scene:
    """`scene` in which every pursuer knows how near it has to come; goals that move begin at the start."""
    place = {agent.id: a for a, agent in enumerate(scene.agents)}
    agents = list(scene.agents)
    for a, agent in enumerate(agents):
        goal = agent.moving_goal
        if goal is not None and goal.kind == "pursue" and not goal.capture:
            known = np.array([place[name] for name in goal.others])
            kept = PairSettings(scene).between(np.array([a]), known).distance
            goal = replace(goal, capture=CAPTURE * float(kept.max()))
        if goal is not None:
            agents[a] = replace(agent, goal=agent.start, moving_goal=goal)
    every = scene.replan_every or REPLAN_EVERY
    return replace(scene, agents=tuple(agents), replan_every=every)


def moving_faults(scene: Scene, defaults: SharedFields, hints: Hints) -> list[Fault]:
    """What of a scene does not go together with goals that move, and names that mean nobody."""
    if not is_play(scene):
        if scene.replan_every is None:
            return []
        return [
            ("replan_every", "belongs to goals that move, perception and tasks; there are none")
        ]
    faults = _unknown(scene, hints)
    needs = f"{PLAYED} needs"
    if scene.map is None:
        faults.append(("map", f"is missing; {needs} one"))
    open_end = scene.horizon_rule == "auto" and not scene.tasks
    if scene.minimise != "energy" or open_end:
        text = "needs a horizon that is stated, and goes with `minimise: energy` alone"
        faults.append(("minimise", f"{PLAYED} {text}"))
    elif not scene.tasks and (scene.replan_every or 0.0) >= scene.horizon:
        every, last = distinct(scene.replan_every or 0.0, scene.horizon)
        text = f"is {every} s; less than the horizon {last} s is expected"
        faults.append(("replan_every", text))
    if scene.assignments:
        faults.append(("agents", f"nobody is assigned points in {PLAYED}"))
    for k, rule in enumerate(scene.pairs):
        if rule.meet is not None:
            faults.append((f"pairs[{k}].meet", f"does not go together with {PLAYED}"))
    slow = [
        a for a, agent in enumerate(scene.agents) if agent.path is None and agent.max_speed is None
    ]
    text = f"is missing; {needs} one of everybody, in m/s"
    if slow and len(slow) == len(scene.agents) and defaults.max_speed is None:
        faults.append(("defaults.max_speed", text))
    else:
        faults += [(f"{scene.agent_path(a)}.max_speed", text) for a in slow]
    for a, agent in enumerate(scene.agents):
        faults += [
            (f"{scene.agent_path(a)}.{key}", f"{why} in {PLAYED}")
            for key, why in _unfit(scene, agent)
        ]
    return faults


def _unfit(scene: Scene, agent: Agent) -> Sequence[tuple[str, str]]:
    """Keys of an agent that have no meaning in a play, and why."""
    if agent.path is not None:
        return [("path", "nobody moves on a path")]
    begin = scene.agents[0].start_time
    working = bool(scene.tasks)
    given = [
        (
            "goal",
            "robots with tasks have points as goals",
            working and agent.moving_goal is not None,
        ),
        ("perception", "robots with tasks know of all", working and agent.sight is not None),
        (
            "max_acceleration",
            "robots with tasks start and stop at once",
            working and agent.max_acceleration is not None,
        ),
        ("waypoints", "nobody has waypoints", bool(agent.waypoints)),
        ("after_arrival", "nobody vanishes on arrival", agent.after_arrival == "vanish"),
        ("start_velocity", "everybody starts at rest", agent.start_velocity is not None),
        ("goal", "goals are points or move", bool(agent.goal_places)),
        ("start_time", "everybody starts at the same time", agent.start_time != begin),
        ("max_time", "everybody is there until the horizon", agent.max_time != scene.horizon),
    ]
    return [(key, why) for key, why, wrong in given if wrong]


def _unknown(scene: Scene, hints: Hints) -> list[Fault]:
    """Names of others that nobody, or only the agent itself, has."""
    known = [agent.id for agent in scene.agents]
    faults = []
    for a, agent in enumerate(scene.agents):
        goal = agent.moving_goal
        for name in () if goal is None else goal.others:
            path = f"{scene.agent_path(a)}.goal.{goal.kind}"  # type: ignore[union-attr]
            if name == agent.id:
                faults.append((path, f"is '{name}', the agent itself; another one is expected"))
            elif name not in known:
                hint = hints(name, known) or "; the id of one is expected"
                faults.append((path, f"is '{name}', which is no agent's id{hint}"))
    return faults


def capture_faults(scene: Scene) -> list[Fault]:
    """Captures that need no chase, or that distances do not allow; sight that is too short for these."""
    whole, faults = with_captures(scene), []
    starts = np.array([agent.start for agent in scene.agents])
    everybody = np.arange(len(starts))
    pairs = PairSettings(scene).between(everybody, everybody)
    kept_apart = np.where(pairs.collides, pairs.distance, 0.0)
    for a, agent in enumerate(scene.agents):
        b = int(kept_apart[a].argmax())
        if agent.sight is not None and agent.sight <= kept_apart[a, b]:
            given, least = distinct(agent.sight, float(kept_apart[a, b]))
            other = scene.agents[b].id
            text = f"is {given} m; more than the {least} m that it keeps from {other} is expected"
            faults.append((f"{scene.agent_path(a)}.perception.radius", text))
    faults += _unseen(scene, kept_apart)
    for a, b, capture in captures(whole):
        path, other = f"{scene.agent_path(a)}.goal.capture", scene.agents[b].id
        kept = float(pairs.distance[a, b]) if pairs.collides[a, b] else 0.0
        if capture <= kept:
            given, least = distinct(capture, kept)
            text = f"is {given} m; more than the {least} m that it keeps from {other} is expected"
            faults.append((path, text))
        elif np.hypot(*(starts[a] - starts[b])) <= capture:
            faults.append((path, f"is {capture:g} m, and {other} starts nearer than that"))
    return faults


def _unseen(scene: Scene, kept_apart: FloatArray) -> list[Fault]:
    """Pairs of which one does not see through walls, and which keep more than walls keep between them."""
    radii = np.array([agent.radius for agent in scene.agents])
    hidden = np.array([agent.line_of_sight for agent in scene.agents])
    wide = kept_apart > (radii[:, None] + radii[None, :]) * (1.0 + ROUNDING)
    wrong = np.argwhere(np.triu(wide & (hidden[:, None] | hidden[None, :])))
    faults = []
    for a, b in wrong.tolist():
        who = a if hidden[a] else b
        given, least = distinct(float(kept_apart[a, b]), float(radii[a] + radii[b]))
        text = (
            f"{scene.agents[a].id} and {scene.agents[b].id} keep {given} m, and behind a wall they may be "
            f"{least} m apart, unseen; a distance of at most that is expected"
        )
        faults.append((f"{scene.agent_path(who)}.perception.line_of_sight", text))
    return faults[:1]
