"""Horizons that are not stated but chosen, as long as the arrivals take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stplan.scene.model import Agent, Scene

# Time that everybody has in any case, times what its way takes alone; and diameters that pass one after
# another wherever all have to go the same way.
AMPLE, QUEUED = 2.0, 2.0


def ample_horizon(scene: Scene, durations: Sequence[float]) -> float:
    """A horizon within which arrivals are no trouble, s.

    `durations` (A,) are what agents need at least from their starts, s. Everybody has time to wait for all
    others to pass one after another.
    """
    ends = [
        agent.start_time + AMPLE * duration if agent.path is None else agent.path[-1][2]
        for agent, duration in zip(scene.agents, durations, strict=True)
    ]
    windows = [visit.window[1] for agent in scene.agents for visit in agent.visits if visit.window]
    queue = sum(
        QUEUED * 2.0 * agent.radius / agent.max_speed
        for agent in scene.agents
        if agent.max_speed is not None
    )
    return max([*ends, *windows]) + queue


def with_horizon(scene: Scene, horizon: float) -> Scene:
    """`scene` with another `horizon` (s), also for the agents whose latest arrival was the old one."""
    agents = tuple(
        replace(agent, max_time=horizon)
        if agent.path is None and agent.max_time == scene.horizon
        else agent
        for agent in scene.agents
    )
    return replace(scene, horizon=horizon, agents=agents)


def with_chosen_horizon(scene: Scene, latest: float) -> Scene:
    """`scene`, whose horizon was open, with one that ends with the `latest` arrival, s."""
    return replace(with_horizon(scene, latest), horizon_rule="chosen")


def least_duration(agent: Agent, length: float) -> float:
    """How long a way of `length` m takes at least within the limits of `agent`, dwells included, s."""
    speed, rate = agent.max_speed, agent.max_acceleration
    moving = 0.0
    if speed is not None:
        moving = length / speed
    if rate is not None:
        # From rest to rest: speeding up all the way to its middle, or up to the speed that is allowed.
        moving = max(moving, 2.0 * np.sqrt(length / rate))
        if speed is not None and length * rate > speed**2:
            moving = length / speed + speed / rate
    return float(moving + sum(visit.dwell for visit in agent.visits))
