"""What of a scene may be changed where a search found no clear curves, and more time alone may not help."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.problem.planning_problem import PlanningProblem
from stplan.reasons import Reason

# Ways that take so many times the time scale to keep pace are hardly told apart in time.
FAST = 3.0
# Margins over this were asked for.
USUAL_MARGIN = 1.05


def remedies(problem: PlanningProblem, reasons: Sequence[Reason]) -> tuple[Reason, ...]:
    """Advice beside the `reasons` why nothing was found."""
    settings = problem.scene.seeding
    found = []
    pace = usual_pace(problem)
    if pace > FAST * problem.time_scale:
        found.append(Reason("time scale", figures={"speed": pace}))
    if settings.method != "auto":
        found.append(Reason("method"))
    if settings.margin > USUAL_MARGIN:
        found.append(Reason("margin", figures={"margin": settings.margin}))
    if any(reason.kind in ("touching", "order") for reason in reasons):
        found.append(Reason("more time"))
    return tuple(found)


def usual_pace(problem: PlanningProblem) -> float:
    """The median of the speeds (m/s) that agents would have if they went straight in the time they like."""
    planned = ~problem.prescribed
    if not planned.any():
        return 0.0
    way = np.hypot(*(problem.goals - problem.starts).T)
    return float(np.median((way / (problem.preferred_times - problem.start_times))[planned]))
