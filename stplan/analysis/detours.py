"""Ways that agents would take alone, and how much longer they go because of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.analysis.paths import path_length
from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.elastic_bands.geodesics import geodesic_curves

# Longer than alone by more than this share counts.
LONGER = 0.01


@dataclass(frozen=True)
class Detour:
    """How far an agent goes, and how far it would go alone, m."""

    agent: str
    length: float
    alone: float


def ways_alone(problem: PlanningProblem) -> list[FloatArray | None]:
    """The (n, 3) curve of every agent if nobody else were there, as the user's: short, at constant speed.

    None where the walls let it through nowhere.
    """
    local = problem.in_frame
    written = local.written
    return [
        None if way is None else written.outside_curve(agent, way)
        for agent, way in zip(written.scene.agents, geodesic_curves(local), strict=True)
    ]


def detours(crowd: Crowd, alone: Sequence[FloatArray | None]) -> list[Detour]:
    """Detours of agents that find their own way, the longest first; `alone` in the crowd's order."""
    found = []
    for a in np.flatnonzero(~crowd.prescribed).tolist():
        way = alone[a]
        length = path_length(crowd.lines.curve(a))
        if way is not None and length > (1.0 + LONGER) * path_length(way):
            found.append(Detour(crowd.lines.agent_ids[a], length, path_length(way)))
    return sorted(found, key=lambda detour: detour.alone - detour.length)
