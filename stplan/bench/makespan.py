"""The least time by which everybody can arrive.

Everyone would like to arrive at the same impossibly early time, and what is planned is as near to it as
the limits of motion and the others leave. Ever shorter horizons give other initial curves; the best plan
of all is kept.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stplan.callbacks import Progress
from stplan.errors import SeedingError
from stplan.planner import Plan, plan
from stplan.scene.model import Agent, Scene

# Shares of the time between the least that the limits of motion leave and the scene's own horizon.
SHARES = (0.5, 0.25)
# Weight of arriving late, per mass: a second is worth more than the energy of hurrying.
EAGERNESS = 30.0
# Strong barriers first, and slowly weaker ones: a wish this strong would otherwise wedge agents together.
PATIENCE: dict[str, Any] = {
    "mu": 10.0, "outer_iterations": 12, "max_iterations": 200,
    "step_tolerance": 1e-4, "optimality_tolerance": 1e-4,
}  # fmt: skip
# How long initial curves are looked for at every horizon (s).
SEED_LIMIT = 15.0


@dataclass(frozen=True)
class Fastest:
    """The certified plan of the least makespan found, and the time (s) the search for it took."""

    plan: Plan
    makespan: float
    seconds: float
    solves: int


def fastest(scene: Scene, *, progress: Progress) -> Fastest | None:
    """The best plan of all horizons down to the first that has none; None where there is none at all."""
    began = time.perf_counter()
    least = max(shortest_time(agent) for agent in scene.agents)
    best: Plan | None = None
    solves = 0
    for share in SHARES:
        horizon = least + share * (scene.final_time - least)
        found = _planned(scene, horizon, least)
        solves += 1
        if found is None:
            progress(f"{scene.name}: no plan within {horizon:.2f} s")
            break
        progress(
            f"{scene.name}: within {horizon:.2f} s all arrive by {latest_arrival(found):.2f} s"
        )
        if best is None or latest_arrival(found) < latest_arrival(best):
            best = found
    if best is None:
        return None
    return Fastest(best, latest_arrival(best), time.perf_counter() - began, solves)


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
    return found.report.metrics.latest_arrival


def _planned(scene: Scene, horizon: float, wanted: float) -> Plan | None:
    """A certified plan within `horizon` whose agents would like to arrive `wanted`, None if there is none."""
    agents = tuple(
        replace(
            agent,
            max_time=horizon,
            preferred_time=wanted,
            weights=replace(agent.weights, arrival=EAGERNESS * agent.mass),
        )
        for agent in scene.agents
    )
    seeding = replace(scene.seeding, time_limit=SEED_LIMIT)
    solver = replace(scene.solver, **PATIENCE)
    patient = replace(scene, horizon=horizon, agents=agents, seeding=seeding, solver=solver)
    try:
        found = plan(patient)
    except SeedingError:
        return None
    return found if found.exit_status == 0 else None
