"""A plan with the cheapest trajectories that moves of large-neighbourhood search lead to."""

from __future__ import annotations

from dataclasses import replace

from stplan.analysis.cost_bound import bound_with
from stplan.analysis.metrics import metrics
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.improvement.budget import ImprovementBudget
from stplan.optimize.continuation import LiveLine
from stplan.planned import Plan
from stplan.problem.planning_problem import PlanningProblem
from stplan.report import OptimisationReport
from stplan.status import Status

# The moves that planning tries: what is improved later is to try others.
OTHER_MOVES = 1 << 20


def improved_plan(
    result: Plan,
    problem: PlanningProblem,
    budget: ImprovementBudget,
    *,
    rng_shift: int = 0,
    progress: Progress | None = None,
    live: LiveLine | None = None,
    stop: Stop | None = None,
) -> Plan:
    """`result`, which has trajectories, with the cheapest ones found; they hold their certificate.

    Args:
        problem: of its scene, in which everybody ends where its trajectories do.
        rng_shift: added to the scene's `rng_seed`, for other moves.
    """
    from stplan.improvement import search

    lines = result.trajectories or result.seed
    found = search.improve(
        problem,
        lines,
        budget,
        rng_seed=result.scene.seeding.rng_seed + rng_shift,
        progress=progress or unheard,
        live=live,
        stop=stop or never,
    )
    content = replace(result.report, improvement=found.record)
    if found.optimisation is not None:
        content = replace(
            content,
            status=found.optimisation.status,
            certificate=found.certificate,
            metrics=metrics(result.scene, found.world_lines),
            optimisation=OptimisationReport.of(result.scene, found.optimisation),
        )
        if content.bound is not None:
            known = content.bound
            bound = bound_with(result.scene, found.world_lines, known.least, known.together)
            content = replace(content, bound=bound)
    if found.interrupted:
        content = replace(content, status=Status.INTERRUPTED)
    return replace(result, trajectories=found.world_lines, report=content)
