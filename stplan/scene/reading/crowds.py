"""Entries of `agents` that stand for a crowd or a stream: where, and when, each of it starts and ends."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.maps.obstacles import exactly_one
from stplan.scene.format.agents import MOST_AGENTS, CrowdFile, StreamFile
from stplan.scene.format.places import SHAPES, CrowdGoalFile
from stplan.schema.mapping import Fault


def crowd_ends(entry: CrowdFile, path: str, faults: list[Fault]) -> tuple[list[Any], list[Any]]:
    """Starts and goals of a crowd at `path`: points, or what the file says of places."""
    count = entry.count
    starts: list[Any] = [entry.start] * count
    goals: list[Any] = [entry.goal] * count
    points = entry.start.points
    if points is not None:
        exactly_one(entry.start, ("place", "points", *SHAPES), f"{path}.start", faults)
        if len(points) != count:
            text = f"is a list of {len(points)}; one of {count}, as many as `count`, is expected"
            faults.append((f"{path}.start.points", text))
        starts = [*points, *([points[0]] * count)][:count]
    assigned = assigned_points(entry)
    if assigned:
        if len(assigned) < count:
            text = (
                f"is a list of {len(assigned)}; one of at least {count}, an agent each, is expected"
            )
            faults.append((f"{path}.goal.assign", text))
        goals = [*assigned, *([assigned[0]] * count)][:count]
    return starts, goals


def assigned_points(entry: CrowdFile) -> list[list[float]]:
    """The points of which everybody gets one, none where the crowd has another goal."""
    goal = entry.goal
    return (goal.assign or []) if isinstance(goal, CrowdGoalFile) else []


def stream_agents(
    entry: StreamFile, path: str, faults: list[Fault], rng_seed: int
) -> list[dict[str, Any]]:
    """Keys of their own of all agents of a stream at `path`, in the order of their times."""
    begin, end = entry.during
    if begin >= end:
        text = f"reaches from {begin:g} s to {end:g} s; a later end is expected"
        faults.append((f"{path}.during", text))
        return []
    if entry.start_time is not None:
        faults.append((f"{path}.start_time", "belongs to single agents; a stream has `during`"))
    if entry.allowed_time is not None and entry.max_time is not None:
        text = "cannot be said beside max_time; one of them is expected"
        faults.append((f"{path}.allowed_time", text))
    times = _times(entry, rng_seed)
    if not len(times):
        faults.append((path, "lets nobody in: a longer time or a higher rate is expected"))
    agents = []
    for time in times.tolist():
        own: dict[str, Any] = {"start": entry.source, "goal": entry.goal, "start_time": time}
        if entry.allowed_time is not None:
            own["max_time"] = time + entry.allowed_time
        agents.append(own)
    return agents


def _times(entry: StreamFile, rng_seed: int) -> FloatArray:
    """When agents of a stream appear, s: evenly, or as a Poisson process of its rate."""
    begin, end = entry.during
    most = int(min(entry.rate * (end - begin), MOST_AGENTS)) + 1
    if entry.arrivals != "poisson":
        times = begin + np.arange(most) / entry.rate
    else:
        rng = np.random.default_rng([rng_seed, zlib.crc32(entry.id.encode())])
        # Far more than will be needed, so that the time is full.
        gaps = rng.exponential(1.0 / entry.rate, size=2 * most + 40)
        times = begin + np.cumsum(gaps)
    return times[times < end][: MOST_AGENTS + 1]
