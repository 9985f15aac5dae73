"""When agents can arrive at the earliest, each and all of them, on any plan.

Nobody arrives before it has come along its shortest way within its limits of motion, through its windows and
dwells (docs/method.md has the proof).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.analysis.shortest_trips import shortest_duration, shortest_legs
from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem

# Share of durations by which bounds are made smaller, against rounding here and in certificates.
ROUNDING = 1e-8


@dataclass(frozen=True)
class ArrivalBound:
    """Earliest arrivals on any plan.

    Attributes:
        agents: their names.
        earliest: (A,) no agent arrives before this, s.
        makespan: not all have arrived before this, s.
        total: the sum of all arrival times is at least this, s.
    """

    agents: tuple[str, ...]
    earliest: FloatArray
    makespan: float
    total: float

    def as_dict(self) -> dict[str, Any]:
        """For the report."""
        return {
            "makespan": self.makespan,
            "total": self.total,
            "agents": [
                {"agent": name, "earliest": earliest}
                for name, earliest in zip(self.agents, self.earliest.tolist(), strict=True)
            ],
        }


def arrival_bound(problem: PlanningProblem) -> ArrivalBound:
    """The earliest arrivals in `problem`, in the user's time; prescribed motion arrives when it does."""
    earliest = problem.frame.times(earliest_arrivals(problem, shortest_legs(problem)))
    return ArrivalBound(problem.agent_ids, earliest, float(earliest.max()), float(np.sum(earliest)))


def earliest_arrivals(problem: PlanningProblem, legs: list[FloatArray]) -> FloatArray:
    """(A,) when every agent can arrive at the earliest if nobody else is there, in the time of `problem`.

    Args:
        legs: lower bounds of its ways between stops, m.
    """
    return np.array(
        [
            agent.max_time
            if agent.path is not None
            else agent.start_time + (1.0 - ROUNDING) * shortest_duration(agent, own)
            for agent, own in zip(problem.scene.agents, legs, strict=True)
        ]
    )
