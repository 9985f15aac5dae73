"""The certificate of what was executed while the world changed.

Between two changes the world is as the last of them left it: who is there keeps its distance from the others
and from the walls of then. In the end everybody is where the last word on it says. Motion is judged on whole
curves, by the limits of then; only who is stopped by a delay stops at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stplan.amounts import amount
from stplan.arrays import FloatArray
from stplan.certify.certificate import Certificate, certify
from stplan.certify.ends import broken_ends, broken_start
from stplan.certify.motion import LONGEST_SHARE, Peak
from stplan.certify.places import broken_assignments
from stplan.certify.tightest import Tightest
from stplan.problem.continuation import curves_of, piece_of
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import World, worlds_of
from stplan.scene.model import Agent, Scene, WorldChange
from stplan.scene.parts import part_of

if TYPE_CHECKING:
    from stplan.world import FreeSpace

# A delay stops an agent at a knot this near to its time, as a share of the curve's duration.
SAME_TIME = 1e-9


def certify_history(
    scene: Scene, spaces: Sequence[FreeSpace | None], lines: WorldLines
) -> Certificate:
    """Check `lines`, one for everybody who ever was there, against `scene` and its changes.

    Args:
        spaces: the map of every world (`worlds_of`), None in the open plane.
    """
    worlds, curves = worlds_of(scene), curves_of(lines)
    violations = _broken_presence(worlds, curves) or _broken_ends(worlds, curves)
    if violations:
        return Certificate(tuple(violations), (), (), 0, 0)
    parts = [
        certify(*found)
        for world, space in zip(worlds, spaces, strict=True)
        if (found := _executed(world, space, curves)) is not None
    ]
    stops = [(change.at, name) for change in scene.changes for name, _ in change.delays]
    peaks = [
        peak
        for name, curve in curves.items()
        for peak in _peaks(worlds, name, curve, [at for at, who in stops if who == name])
    ]
    last = parts[-1]
    broken = [sentence for part in parts for sentence in part.violations]
    broken += [str(peak) for peak in peaks if not peak.holds]
    return replace(
        last,
        violations=tuple(dict.fromkeys(broken)),
        pairs=_tightest(part.pairs for part in parts),
        walls=_tightest(part.walls for part in parts),
        limits=tuple(peaks),
        rounding=max(part.rounding for part in parts),
        eased=tuple(one for part in parts for one in part.eased),
    )


def _tightest(parts: Iterable[Sequence[Tightest]]) -> tuple[Tightest, ...]:
    """The tightest spot of everybody in all parts."""
    found: dict[tuple[str, ...], Tightest] = {}
    for part in parts:
        for spot in part:
            known = found.get(spot.who)
            if known is None or spot.clearance < known.clearance:
                found[spot.who] = spot
    return tuple(found.values())


def _broken_presence(worlds: Sequence[World], curves: Mapping[str, FloatArray]) -> list[str]:
    """A sentence for everybody who should have a curve, or should not."""
    ever = {name for world in worlds for name in world.agents}
    sentences = [f"{name}: has no trajectory" for name in sorted(ever - curves.keys())]
    sentences += [f"{name}: is not in the scene" for name in sorted(curves.keys() - ever)]
    for name, curve in curves.items():
        if len(curve) < 2 or not np.isfinite(curve).all() or (np.diff(curve[:, 2]) <= 0).any():
            sentences.append(f"{name}: needs at least two finite knots whose times increase")
    if sentences:
        return sentences
    for world in worlds:
        for name in world.removed & curves.keys():
            if curves[name][-1, 2] > world.begin:
                sentences.append(
                    f"{name}: is there after {amount(world.begin)} s, when it is removed"
                )
    return list(dict.fromkeys(sentences))


def _broken_ends(worlds: Sequence[World], curves: Mapping[str, FloatArray]) -> list[str]:
    """Who does not start as it was to at first, or does not end as the last word on it says."""
    first: dict[str, Agent] = {}
    for world in worlds:
        for name, agent in world.agents.items():
            first.setdefault(name, agent)
    last = worlds[-1]
    sentences = []
    assigned = {last.scene.agents[a].id for one in last.scene.assignments for a in one.members}
    for name, agent in last.agents.items():
        begin = first[name]
        whole = replace(
            agent,
            start=begin.start,
            start_time=begin.start_time,
            start_velocity=begin.start_velocity,
            start_duration=begin.start_duration,
        )
        sentences += broken_ends(whole, curves[name], assigned=name in assigned)
    for name, agent in first.items():
        if name not in last.agents:
            sentences += broken_start(agent, curves[name])
    if assigned and not sentences and not last.removed:
        ends = np.array([curves[agent.id][-1, :2] for agent in last.scene.agents])
        sentences += broken_assignments(last.scene, ends)
    return sentences


def _executed(
    world: World, space: FreeSpace | None, curves: Mapping[str, FloatArray]
) -> tuple[Scene, FreeSpace | None, WorldLines] | None:
    """What was executed in a world, as a scene of its own that asks for distances alone.

    None where nobody was there.
    """
    kept, agents, pieces = [], [], []
    for a, agent in enumerate(world.scene.agents):
        curve = curves[agent.id] if agent.id not in world.removed else None
        if curve is None or curve[0, 2] >= world.end:
            continue
        begin, end = max(world.begin, float(curve[0, 2])), min(world.end, float(curve[-1, 2]))
        if begin >= end:
            if agent.after_arrival == "vanish" or begin >= world.end:
                continue
            until = min(world.end, max(world.scene.final_time, begin + 1.0))
            piece = np.array([[*curve[-1, :2], begin], [*curve[-1, :2], until]])
        else:
            piece = piece_of(curve, begin, end)
        kept.append(a)
        agents.append(_free(agent, piece))
        pieces.append(piece)
    if not kept:
        return None
    part = part_of(world.scene, kept, agents)
    # Those who meet do so some time, not in every part.
    rules = tuple(replace(rule, meet=None) for rule in part.pairs)
    horizon = world.end if np.isfinite(world.end) else part.horizon
    part = replace(part, pairs=rules, horizon=horizon)
    return part, space, WorldLines.from_curves([one.id for one in agents], pieces)


def _free(agent: Agent, piece: FloatArray) -> Agent:
    """An agent that is asked for nothing but a `piece` of its curve."""
    (x, y, t), (u, v, end) = piece[0].tolist(), piece[-1].tolist()
    return replace(
        agent, start=(x, y), goal=(u, v), start_time=t, max_time=end, goal_places=(), waypoints=(), visits=(),
        path=None, max_speed=None, max_acceleration=None, start_velocity=None, start_duration=0.0,
    )  # fmt: skip


def _peaks(
    worlds: Sequence[World], name: str, curve: FloatArray, stops: Sequence[float]
) -> list[Peak]:
    """Greatest speed and acceleration of a whole curve over the limits of then, like `motion_peaks`."""
    known = [(world, world.agents[name]) for world in worlds if name in world.agents]
    times = curve[:, 2]
    step = np.diff(curve, axis=0)
    velocity = step[:, :2] / step[:, 2:]
    found = []
    for limit, what in (("max_speed", "speed"), ("max_acceleration", "acceleration")):
        allowed = np.full(len(times), np.inf)
        for world, agent in known:
            value = getattr(agent, limit)
            if value is None or agent.path is not None:
                continue
            # A segment's speed lasts until the next knot, changes of velocity are at knots.
            until = np.append(times[1:], times[-1]) if what == "speed" else times
            now = (times < world.end) & ((times >= world.begin) | (until > world.begin))
            allowed[now] = np.minimum(allowed[now], value)
        if what == "speed":
            reached = np.append(np.hypot(velocity[:, 0], velocity[:, 1]), 0.0)
            when = np.append(0.5 * (times[1:] + times[:-1]), times[-1])
        else:
            # Who is taken away under way does not brake; who had arrived before did.
            near = SAME_TIME * (times[-1] - times[0])
            removed = any(
                name in world.removed and times[-1] >= world.begin - near for world in worlds
            )
            before = np.array(known[0][1].start_velocity or (0.0, 0.0))
            after = velocity[-1] if removed else np.zeros(2)
            change = np.diff(np.vstack([before, velocity, after]), axis=0)
            at_stop = [
                k
                for stop in stops
                for k in np.flatnonzero(np.abs(times - stop) <= SAME_TIME * (times[-1] - times[0]))
            ]
            lasts = step[:, 2].copy()
            for k in at_stop:
                # What the delay cut short was planned to last longer.
                lasts[k - 1] = max(lasts[max(k - 2, 0) : k])
            half = np.concatenate([[0.0], 0.5 * lasts, [0.0]])
            between = np.minimum(half[:-1] + half[1:], LONGEST_SHARE * (times[-1] - times[0]))
            reached, when = np.hypot(change[:, 0], change[:, 1]) / between, times
            reached[at_stop] = 0.0
        if not np.isfinite(allowed).any():
            continue
        worst = int(np.argmax(reached / allowed))
        found.append(
            Peak(name, what, float(allowed[worst]), float(reached[worst]), float(when[worst]))
        )
    return found


def rest_certificate(
    change: WorldChange, space: FreeSpace | None, curves: Mapping[str, FloatArray]
) -> Certificate | None:
    """Whether whole `curves` stay clear after a `change` if all go on as before; None if nobody does."""
    world = World(change.scene, change.at, np.inf, change.removed)
    there = {name: curve for name, curve in curves.items() if name in world.agents}
    new = frozenset(world.agents.keys() - there.keys())
    found = _executed(replace(world, removed=world.removed | new), space, there)
    return None if found is None else certify(*found)
