"""Curves that search found, relaxed: it sends agents round and makes them queue more than it has to.

Shortened curves are pulled tight as elastic bands and pushed apart again; the result is taken where it is
clear and costs less.
"""

from __future__ import annotations

from collections.abc import Sequence

from stplan.arrays import FloatArray
from stplan.callbacks import Stop
from stplan.deadline import passed
from stplan.problem.kinetic_cost import total_kinetic_cost
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, held_requirement
from stplan.seeding.elastic_bands.relaxation import relax
from stplan.seeding.shortcutting.shortcuts import take_shortcuts

TIGHTENING_KNOTS = 60
TIGHTENING_SWEEPS = 160


def tighten(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    required: Requirement,
    *,
    rng_seed: int = 0,
    stopped: Stop = passed,
) -> list[FloatArray]:
    """Clear curves at most as dear as the shortened `curves`; once `stopped`, as far as they have come.

    Curves that hold less than what is `required` need not hold more than they do.
    """
    held = held_requirement(problem, curves, required)
    shortened = take_shortcuts(problem, curves, held, rng_seed=rng_seed, stopped=stopped)
    found = relax(
        problem,
        required,
        shortened,
        num_knots=TIGHTENING_KNOTS,
        rng_seed=rng_seed,
        max_sweeps=TIGHTENING_SWEEPS,
        stopped=stopped,
    )
    relaxed, before = (total_kinetic_cost(problem.masses, own) for own in (found.curves, shortened))
    return found.curves if found.clear and relaxed < before else shortened
