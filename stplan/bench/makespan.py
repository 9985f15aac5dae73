"""The least time by which everybody can arrive: the horizon is lowered until no plan is found."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stplan.errors import SeedingError
from stplan.pipeline import Plan, plan
from stplan.scene.model import Agent, Scene

# The search ends when the makespan is known to so many seconds (s).
RESOLUTION = 0.05
# How long initial curves are looked for at every horizon (s).
SEED_LIMIT = 10.0
# Ways of drawing the random numbers of the initial curves that are tried before a horizon counts as too
# short.
DRAWS = 2


@dataclass(frozen=True)
class Fastest:
    """The certified plan of the least makespan found, and the time (s) the search for it took."""

    plan: Plan
    makespan: float
    seconds: float
    solves: int


def fastest(scene: Scene, *, progress: Callable[[str], None]) -> Fastest | None:
    """Bisect between the least time that the limits of motion leave and the scene's own horizon.

    None where not even the scene's own horizon has a plan.
    """
    began = time.perf_counter()
    low = max(shortest_time(agent) for agent in scene.agents)
    high = scene.final_time
    best: Plan | None = None
    solves = 0
    trial = high
    while best is None or high - low > RESOLUTION:
        found = None
        for draw in range(DRAWS):
            solves += 1
            found = _planned(scene, trial, draw)
            if found is not None:
                break
        progress(f"{scene.name}: {'a' if found else 'no'} plan within {trial:.2f} s")
        if found is None and best is None:
            return None
        if found is None:
            low = trial
        else:
            best, high = found, latest_arrival(found)
        trial = 0.5 * (low + high)
    return Fastest(best, high, time.perf_counter() - began, solves)


def shortest_time(agent: Agent) -> float:
    """The least time an agent alone in the open plane needs from rest to rest, s."""
    distance = float(np.hypot(agent.goal[0] - agent.start[0], agent.goal[1] - agent.start[1]))
    speed, acceleration = agent.max_speed or np.inf, agent.max_acceleration or np.inf
    # Too short a way to reach the greatest speed: half of it speeding up, half slowing down.
    if speed**2 / acceleration >= distance:
        return 2.0 * float(np.sqrt(distance / acceleration))
    return distance / speed + speed / acceleration


def latest_arrival(found: Plan) -> float:
    """When the last agent arrives, s."""
    return float(found.report["metrics"]["latest_arrival"])


def _planned(scene: Scene, horizon: float, draw: int) -> Plan | None:
    """A certified plan within `horizon`, None where there is none."""
    agents = tuple(replace(agent, max_time=horizon) for agent in scene.agents)
    seeding = replace(scene.seeding, time_limit=SEED_LIMIT, rng_seed=scene.seeding.rng_seed + draw)
    try:
        found = plan(replace(scene, horizon=horizon, agents=agents, seeding=seeding))
    except SeedingError:
        return None
    return found if found.exit_status == 0 else None
