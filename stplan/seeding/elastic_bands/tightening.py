"""Curves that search found, relaxed: it sends agents round and makes them queue more than it has to.

Polished curves are pulled tight and pushed apart again; the result is taken where it is clear and costs
less.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.kinetic import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.elastic_bands.relaxation import relax
from stplan.seeding.shortcutting.shortcuts import polish

SMOOTHING_KNOTS = 60
SMOOTHING_SWEEPS = 160


def smooth_curves(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    *,
    margin: float,
    rng_seed: int,
    check: Callable[[], None],
) -> list[FloatArray]:
    """Clear curves at most as dear as the polished `curves`; `check` is called now and then."""
    polished = polish(problem, curves, margin=margin, rng_seed=rng_seed, check=check)
    result = relax(
        problem,
        polished,
        num_knots=SMOOTHING_KNOTS,
        margin=margin,
        time_limit=np.inf,
        rng_seed=rng_seed,
        max_sweeps=SMOOTHING_SWEEPS,
        check=check,
    )
    relaxed, before = (total_kinetic_cost(problem.masses, own) for own in (result.curves, polished))
    if result.solved and relaxed < before:
        return result.curves
    return polished
