"""Whether every agent of the scene has one curve that starts, ends and goes as it was asked to."""

from __future__ import annotations

import numpy as np

from stplan.amounts import LARGEST, amount
from stplan.arrays import FloatArray
from stplan.certify.motion import missed_visit, place_tolerance, time_tolerance
from stplan.certify.places import outside_all
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene


def agents_that_differ(scene: Scene, lines: WorldLines) -> list[str]:
    """A sentence for every agent that scene and curves do not share."""
    wanted = dict.fromkeys(agent.id for agent in scene.agents)
    found = dict.fromkeys(lines.agent_ids)
    sentences = [f"{name}: has no trajectory" for name in wanted if name not in found]
    sentences += [f"{name}: is not in the scene" for name in found if name not in wanted]
    if len(found) != len(lines.agent_ids):
        sentences.append("an agent has more than one trajectory")
    return sentences


def _no_curve(agent: Agent, curve: FloatArray) -> list[str]:
    """Why `curve` is none that anything could be said of."""
    if len(curve) < 2 or not np.isfinite(curve).all():
        return [f"{agent.id}: needs at least two finite knots"]
    if np.abs(curve).max() > LARGEST:
        return [f"{agent.id}: a coordinate or time is beyond {LARGEST:g}"]
    return []


def broken_start(agent: Agent, curve: FloatArray) -> list[str]:
    """Start, its time and velocity, and the order of times of one agent, `curve` (n + 1, 3)."""
    sentences = _no_curve(agent, curve)
    if sentences:
        return sentences
    if (np.diff(curve[:, 2]) <= 0).any():
        knot = int(np.flatnonzero(np.diff(curve[:, 2]) <= 0)[0]) + 1
        sentences.append(f"{agent.id}: time does not increase at knot {knot}")
    if tuple(curve[0]) != (*agent.start, agent.start_time):
        sentences.append(
            f"{agent.id}: starts at {tuple(curve[0].tolist())}, "
            f"not at {(*agent.start, agent.start_time)}"
        )
    if agent.starts_as_given and _starts_otherwise(agent, curve):
        step = curve[1] - curve[0]
        sentences.append(
            f"{agent.id}: starts with velocity {tuple((step[:2] / step[2]).tolist())} m/s, "
            f"not with {agent.start_velocity} m/s"
            + (f" for {agent.start_duration} s" if agent.start_duration else "")
        )
    return sentences


def broken_ends(agent: Agent, curve: FloatArray, *, assigned: bool = False) -> list[str]:
    """Ends, times, waypoints and the prescribed path of one agent, `curve` (n + 1, 3).

    Where an `assigned` agent ends is not looked at.
    """
    sentences = _no_curve(agent, curve)
    if sentences:
        return sentences
    sentences = broken_start(agent, curve)
    if agent.goal_places:
        outside = outside_all(agent.goal_places, curve[-1, :2], place_tolerance(agent, curve))
        sentences += [f"{agent.id}: {outside}"] if outside else []
    elif not assigned and tuple(curve[-1, :2]) != agent.goal:
        sentences.append(
            f"{agent.id}: ends at {tuple(curve[-1, :2].tolist())}, not at {agent.goal}"
        )
    if curve[-1, 2] > agent.max_time:
        sentences.append(f"{agent.id}: arrives at {curve[-1, 2]} s, after {agent.max_time} s")
    if sentences:
        return sentences
    missed = missed_visit(agent, curve)
    if missed:
        return [missed]
    return [] if agent.path is None else _left_path(agent, curve)


def _starts_otherwise(agent: Agent, curve: FloatArray) -> bool:
    """Whether the first segment does not lead where the agent's velocity does, or not for so long."""
    place, time = curve[1, :2] - curve[0, :2], float(curve[1, 2] - curve[0, 2])
    if time < agent.start_duration - time_tolerance(curve):
        return True
    off = np.hypot(*(place - time * np.array(agent.start_velocity)))
    return bool(off > place_tolerance(agent, curve))


def _left_path(agent: Agent, curve: FloatArray) -> list[str]:
    given = np.array(agent.path)
    times = np.union1d(given[:, 2], curve[:, 2])
    gap = max(
        np.abs(
            np.interp(times, given[:, 2], given[:, x]) - np.interp(times, curve[:, 2], curve[:, x])
        ).max()
        for x in range(2)
    )
    if gap > place_tolerance(agent, curve) or curve[-1, 2] != given[-1, 2]:
        return [f"{agent.id}: leaves its given path by {amount(gap, 3)} m"]
    return []
