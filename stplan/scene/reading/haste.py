"""Scenes in which arrivals are to be early: what they need, and a horizon that is long enough."""

from __future__ import annotations

import math

import numpy as np

from stplan.scene.format.agents import SharedFields
from stplan.scene.horizon import ample_horizon, least_duration, with_horizon
from stplan.scene.model import Scene
from stplan.schema.mapping import Fault


def latest_time(horizon: float | str | None) -> float | None:
    """The horizon of a file as a number: no limit where it is yet to be chosen."""
    return math.inf if isinstance(horizon, str) else horizon


def with_long_horizon(scene: Scene) -> Scene:
    """`scene` with a horizon that is finite and long enough in the open, where it is yet to be chosen."""
    if scene.horizon_rule != "auto" or not scene.agents:
        return scene
    durations = []
    for agent in scene.agents:
        stops = np.array([agent.start, *agent.waypoints, agent.goal])
        durations.append(least_duration(agent, float(np.hypot(*np.diff(stops, axis=0).T).sum())))
    return with_horizon(scene, ample_horizon(scene, durations))


def haste_faults(scene: Scene, defaults: SharedFields) -> list[Fault]:
    """What is missing for arrivals to be early, and a horizon that has no reason to be chosen."""
    if scene.minimise == "energy":
        if scene.horizon_rule == "stated":
            return []
        text = "is auto; a time in s is expected, or `minimise: arrivals` or `makespan`"
        return [("horizon", text)]
    slow = [
        a for a, agent in enumerate(scene.agents) if agent.path is None and agent.max_speed is None
    ]
    if not slow:
        return []
    text = f"is missing; with `minimise: {scene.minimise}` a speed in m/s is expected"
    if len(slow) < len(scene.agents) or defaults.max_speed is not None:
        return [(f"{scene.agent_path(a)}.max_speed", text) for a in slow]
    return [("defaults.max_speed", text)]
