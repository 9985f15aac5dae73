"""When agents can arrive at the earliest, each and all of them, on any plan.

Nobody arrives before it has come along its shortest way within its limits of motion, through its windows and
dwells, and many not before they are through the gates that they have to pass (docs/method.md has the proof).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.analysis.capacity import passings
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
    legs = shortest_legs(problem)
    earliest = earliest_arrivals(problem, legs)
    makespan, delay = float(earliest.max()), 0.0
    left = np.ones(len(earliest), dtype=bool)
    through = passings(problem, legs)
    gains = [one.total - float(earliest[one.agents].sum()) for one in through]
    for k in np.argsort(-np.array(gains), kind="stable").tolist():
        one = through[k]
        makespan = max(makespan, one.makespan)
        # Nobody is delayed by two gates at once.
        if gains[k] > 0.0 and left[one.agents].all():
            left[one.agents] = False
            delay += gains[k]
    frame = problem.frame
    arrivals = frame.times(earliest)
    return ArrivalBound(
        problem.agent_ids,
        arrivals,
        float(frame.times(np.array([makespan]))[0]),
        float(np.sum(arrivals)) + frame.time * delay,
    )


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
