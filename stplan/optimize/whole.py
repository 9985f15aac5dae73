"""All agents of a problem: together, apart where they never meet, in blocks where they are many."""

from __future__ import annotations

import numpy as np

from stplan.callbacks import Progress, Stop
from stplan.optimize.blocks import block_size, optimise_blocks
from stplan.optimize.components import components, optimise_components
from stplan.optimize.continuation import LiveLine, Optimisation, optimise
from stplan.optimize.parts import DividedProblem
from stplan.optimize.workers import THIS_PROCESS, WorkersFor
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines


def optimise_whole(
    problem: PlanningProblem,
    seed: WorldLines,
    *,
    progress: Progress,
    stop: Stop,
    live: LiveLine | None = None,
    workers: WorkersFor = THIS_PROCESS,
) -> Optimisation:
    """Make `seed` smooth and cheap, by `workers` where there are blocks.

    Raises:
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """
    size = block_size(problem)
    if size is not None:
        return optimise_blocks(
            problem, seed, size, progress=progress, stop=stop, live=live, workers=workers
        )
    formulation = None
    if _separable(problem):
        parts = DividedProblem(problem, seed, stop)
        found = components(parts)
        if len(found) > 1:
            return optimise_components(parts, found, progress=progress, stop=stop, live=live)
        formulation = parts.formulation
    return optimise(problem, seed, progress=progress, stop=stop, live=live, formulation=formulation)


def _separable(problem: PlanningProblem) -> bool:
    """Whether what agents feel of each other ends somewhere."""
    solver = problem.scene.solver
    finite = solver.barrier_range is None or np.isfinite(solver.barrier_range)
    return solver.blocks is None and finite and solver.clearance_model == "contacts"
