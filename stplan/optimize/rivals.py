"""Optimisations of several seeds, given up once they look dearer than the best of those before.

What seeds cost tells little of what they come to: most of it may be haste that the optimiser undoes. After
the first outer iteration, objectives that differ by more than a fiftieth hardly ever change places; it has
the widest barriers, so it moves far in few steps.
"""

from __future__ import annotations

from collections.abc import Sequence

from stplan.callbacks import Stop, unheard
from stplan.optimize.continuation import Optimisation, optimise
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines

# Objectives this many times the least one known at the same time are given up.
SCREEN = 1.02


def optimise_rival(
    problem: PlanningProblem,
    seed: WorldLines,
    known: Sequence[Sequence[float]],
    *,
    stop: Stop,
) -> Optimisation | None:
    """`seed` optimised, None where it looks dearer on the way, or is stopped.

    Args:
        known: objectives of earlier optimisations after each of their outer iterations, in the user's units;
            they are compared at the same number before the last.
    """
    dear = False

    def proceed(objective: float, left: int) -> bool:
        nonlocal dear
        before = [objectives[-1 - left] for objectives in known if len(objectives) > left]
        dear = bool(before) and objective > SCREEN * min(before)
        return not dear

    found = optimise(problem, seed, progress=unheard, stop=stop, proceed=proceed)
    return None if dear or stop() else found
