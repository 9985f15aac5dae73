"""Who arrives later than preferred."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.analysis.waiting import Wait

# Late means by more than this share of the time the agent wanted to take.
LATE = 0.01


@dataclass(frozen=True)
class Late:
    """An agent that arrives after its preferred time (s); `waited` is what its waits cost it."""

    agent: str
    arrival: float
    preferred: float
    waited: float


def timed(crowd: Crowd) -> list[int]:
    """Agents that find their own way and have a preferred time."""
    return np.flatnonzero(~np.isnan(crowd.preferred) & ~crowd.prescribed).tolist()


def late_agents(crowd: Crowd, waits: Sequence[Wait]) -> list[Late]:
    """Late agents, the latest first."""
    late = []
    for a in timed(crowd):
        curve, preferred = crowd.lines.curve(a), float(crowd.preferred[a])
        agent, arrival = crowd.lines.agent_ids[a], float(curve[-1, 2])
        if arrival - preferred > LATE * (preferred - float(curve[0, 2])):
            waited = sum(wait.lost for wait in waits if wait.agent == agent)
            late.append(Late(agent, arrival, preferred, waited))
    return sorted(late, key=lambda entry: entry.preferred - entry.arrival)
