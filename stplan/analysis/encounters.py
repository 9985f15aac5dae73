"""Who would meet whom if everybody went as if alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.certify.pair_clearance import nearest_moments
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.presence import present_until


@dataclass(frozen=True)
class Encounter:
    """Two agents that would come too near: by how much (m), when (s) and where (m)."""

    who: tuple[str, str]
    overlap: float
    time: float
    place: tuple[float, float]


@dataclass(frozen=True)
class Encounters:
    """All of them, the nearest first.

    Attributes:
        num_pairs: how many pairs of agents that have a way have to keep apart.
        all_able: whether every agent has a way.
    """

    found: tuple[Encounter, ...]
    num_pairs: int
    all_able: bool


def encounters(problem: PlanningProblem, alone: Sequence[FloatArray | None]) -> Encounters:
    """Whom everybody would come too near to on its way `alone`, in scene order."""
    able = [a for a, way in enumerate(alone) if way is not None]
    curves = [way for way in alone if way is not None]
    wanted = np.ascontiguousarray(problem.collides[np.ix_(able, able)])
    total = int(np.triu(wanted).sum())
    if not total:
        return Encounters((), 0, len(able) == len(alone))
    lines = WorldLines.from_curves([problem.agent_ids[a] for a in able], curves)
    arrivals = np.array([curve[-1, 2] for curve in curves])
    leaves = present_until(problem.stays[able], arrivals, problem.final_time)
    nearest = nearest_moments(lines, leaves, wanted)
    overlap = problem.distance[np.ix_(able, able)][tuple(nearest.pairs.T)] - nearest.distance
    found = []
    for k in np.argsort(-overlap, kind="stable").tolist():
        if overlap[k] <= 0:
            break
        a, b = nearest.pairs[k].tolist()
        x, y = nearest.middle[k].tolist()
        who = (lines.agent_ids[a], lines.agent_ids[b])
        found.append(Encounter(who, float(overlap[k]), float(nearest.instant[k]), (x, y)))
    return Encounters(tuple(found), total, len(able) == len(alone))
