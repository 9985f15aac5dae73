"""When agents would arrive if nobody were in their way.

Whoever arrives later moves more cheaply; where arriving has a weight, being late costs. Alone on its straight
way of length L through its waypoints, at an even pace in T seconds, an agent pays K^K m L^2 / (2 T) for its
motion and K^T (t_0 + T - T^p)^2 / 2 for its arrival: a convex function of T, whose derivative has one root.
"""

from __future__ import annotations

import numpy as np

from stplan.scene.horizon import least_duration
from stplan.scene.model import Agent, Scene

# Limits are kept with so much to spare: barriers keep curves off them.
SPARE = 1.02
# Shortest duration over the time there is: nobody arrives at once.
LEAST_SHARE = 1e-3
HALVINGS = 60
# Plans of agents who would like to arrive early are looked for within so many times the longest of their
# free durations first.
HURRIED = 3.0


def free_arrival(agent: Agent) -> float:
    """When `agent` would like to arrive, s: no sooner than its limits allow, no later than `max_time`."""
    weights = agent.weights
    if agent.preferred_time is None or weights.arrival <= 0 or agent.path is not None:
        return agent.max_time
    stops = np.array([agent.start, *agent.waypoints, agent.goal])
    length = float(np.hypot(*np.diff(stops, axis=0).T).sum())
    asked = agent.preferred_time - agent.start_time
    whole = agent.max_time - agent.start_time
    # Whose motion costs nothing likes to arrive when it prefers to.
    best = max(asked, 0.0)
    motion = 0.5 * weights.kinetic * agent.mass * length**2
    if motion > 0.0:
        low, high = best, best + (motion / weights.arrival) ** (1.0 / 3.0)
        for _ in range(HALVINGS):
            best = 0.5 * (low + high)
            later = motion > weights.arrival * (best - asked) * best**2
            low, high = (best, high) if later else (low, best)
    least = max(SPARE * least_duration(agent, length), LEAST_SHARE * whole)
    return agent.start_time + min(max(best, least), whole)


def sooner_horizon(scene: Scene) -> float | None:
    """An earlier horizon (s) for `scene`, where nobody has a use for its own; None where somebody has.

    What is planned then depends on how long agents need, and not on how much later they might arrive.
    """
    movers = [agent for agent in scene.agents if agent.path is None]
    timed = any(visit.window for agent in movers for visit in agent.visits)
    timed = timed or any(rule.meet for rule in scene.pairs)
    if timed or not movers or not all(agent.weights.arrival > 0 for agent in movers):
        return None
    longest = max(free_arrival(agent) - agent.start_time for agent in movers)
    last = max(agent.start_time for agent in movers) + HURRIED * longest
    last = max([last, *(agent.path[-1][2] for agent in scene.agents if agent.path)])
    return last if last < min(agent.max_time for agent in movers) else None
