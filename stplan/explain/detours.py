"""Ways that agents would take alone, and how much longer they go because of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from stplan.arrays import FloatArray
from stplan.explain.explanation import Section
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.seeding.elastic_bands.geodesics import geodesic_curves

# Longer than alone by more than this share counts.
LONGER = 0.01


@dataclass(frozen=True)
class Detour:
    """How far an agent goes, and how far it would go alone, m."""

    agent: str
    length: float
    alone: float

    def sentence(self) -> str:
        """In words."""
        more = self.length - self.alone
        share = f" ({more / self.alone:.0%})" if self.alone > 0 else ""
        return (
            f"{self.agent} goes {self.length:.2f} m, {more:.2f} m{share} more than its "
            "shortest way alone"
        )


def ways_alone(problem: PlanningProblem) -> list[FloatArray | None]:
    """The (n, 3) curve of every agent if nobody else were there: short, at constant speed.

    None where the walls let it through nowhere.
    """
    return geodesic_curves(problem)


def detours(scene: Scene, lines: WorldLines, alone: Sequence[FloatArray | None]) -> Section:
    """Detours of agents that plan their way, the longest first; `lines` in scene order."""
    planned = [agent.path is None for agent in scene.agents]
    found = [
        Detour(agent.id, _length(curve), _length(way))
        for agent, curve, way in compress(
            zip(scene.agents, lines.curves(), alone, strict=True), planned
        )
        if way is not None and _length(curve) > (1.0 + LONGER) * _length(way)
    ]
    title = "Detours"
    if not found:
        return Section("detours", title, f"Nobody goes more than {LONGER:.0%} further than alone.")
    found.sort(key=lambda detour: detour.alone - detour.length)
    total = sum(detour.length - detour.alone for detour in found)
    lead = f"{len(found)} of {sum(planned)} agents go further than alone, {total:.2f} m in all:"
    return Section("detours", title, lead, found)


def _length(curve: FloatArray) -> float:
    """Length in the plane, m."""
    return float(np.hypot(*np.diff(curve[:, :2], axis=0).T).sum())
