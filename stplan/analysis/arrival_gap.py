"""How fast a plan is, and how far from as fast as can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.analysis.arrival_bound import ArrivalBound, arrival_bound
from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Objective


@dataclass(frozen=True)
class ArrivalGap:
    """Arrivals of a plan beside the earliest on any plan.

    Attributes:
        minimise: what was to be least.
        starts, arrivals: (A,) s.
    """

    minimise: Objective
    starts: FloatArray
    arrivals: FloatArray
    bound: ArrivalBound

    @property
    def value(self) -> float:
        """What was to be least, s: the sum of the arrival times, or the latest."""
        chosen = self.arrivals.max() if self.minimise == "makespan" else self.arrivals.sum()
        return float(chosen)

    @property
    def least(self) -> float:
        """What no plan is below, s."""
        return self.bound.makespan if self.minimise == "makespan" else self.bound.total

    @property
    def gap(self) -> float | None:
        """Share by which agents may take longer than on the best plan, all together or the last of them."""
        origin = self.starts.min() if self.minimise == "makespan" else self.starts.sum()
        needed = self.least - float(origin)
        return max((self.value - self.least) / needed, 0.0) if needed > 0.0 else None

    @property
    def sentence(self) -> str:
        """How fast the plan is, in words."""
        if self.minimise == "makespan":
            text = f"all have arrived at {self.value:.2f} s, on no plan before {self.least:.2f} s"
        else:
            text = f"arrival times add up to {self.value:.2f} s, on no plan to less than {self.least:.2f} s"
        return text if self.gap is None else f"{text} (gap {100.0 * self.gap:.3g} %)"

    def as_dict(self) -> dict[str, Any]:
        """For the report."""
        return {
            "minimise": self.minimise,
            "value": self.value,
            "least": self.least,
            "gap": self.gap,
            "bound": self.bound.as_dict(),
        }


def arrival_gap(problem: PlanningProblem, lines: WorldLines) -> ArrivalGap:
    """That of `lines`, a plan of `problem` as the user's in scene order."""
    scene = problem.written.scene
    starts = np.array([agent.start_time for agent in scene.agents])
    arrivals = np.asarray(lines.knots[lines.offsets[1:] - 1, 2])
    return ArrivalGap(scene.minimise, starts, arrivals, arrival_bound(problem))
