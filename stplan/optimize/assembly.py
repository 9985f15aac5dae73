"""From a problem and its seed to a formulation, and from that to the programs of its outer loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import Formulation, Penalties, TermSetup
from stplan.costs.registry import build_terms
from stplan.nlp.constraints import Constraints
from stplan.nlp.program import NonlinearProgram
from stplan.nlp.term import Capability, Term
from stplan.optimize.scales import derive_scales
from stplan.optimize.timed_constraints import find_timed_constraints
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.rods import Rods
from stplan.problem.surroundings import Surroundings
from stplan.problem.world_lines import WorldLines
from stplan.seeding.rendezvous import Rendezvous

# Relative padding of all distances; halved clearance of the seed where that is less.
PADDING = 1e-4


def formulate(
    problem: PlanningProblem,
    seed: WorldLines,
    planned: Sequence[Rendezvous] = (),
    surroundings: Surroundings | None = None,
) -> Formulation:
    """What stays the same while `problem` is optimised from `seed`, clear of its `surroundings`.

    Pairs with a `planned` place meet there.
    """
    interactions = problem.interactions if surroundings is None else surroundings.interactions
    layout, knots = KnotLayout.from_offsets(seed.offsets), seed.knots
    formulation = Formulation(
        problem=problem,
        layout=layout,
        rods=Rods.build(
            layout, knots, np.flatnonzero(problem.stays), problem.final_time, problem.time_scale,
            None if surroundings is None else surroundings.rods,
        ),
        scales=derive_scales(problem, layout, knots, interactions.distance),
        timed=find_timed_constraints(problem, layout, knots, planned),
        surroundings=surroundings,
    )  # fmt: skip
    return replace(formulation, padding=padding(formulation, knots))


def padding(formulation: Formulation, knots: FloatArray) -> float:
    """As much relative padding of distances as the clearance at `knots` (M, 3) allows."""
    scales, widest = formulation.scales, float(formulation.interactions.distance.max())
    # Barriers of hardly any range would not see what the padding needs.
    reach = 2.0 * PADDING * widest
    if scales.pair_reach.min() < reach:
        scales = replace(scales, pair_reach=np.maximum(scales.pair_reach, reach))
    scales = replace(scales, wall_reach=np.maximum(scales.wall_reach, reach))
    setup = TermSetup(replace(formulation, scales=scales, padding=0.0), knots, 0.0)
    terms = build_terms(setup, Capability.CLEARANCE)
    least = min((term.least_clearance(knots) for term in terms), default=np.inf)
    return float(min(PADDING, 0.5 * max(least, 0.0) / widest))


def assemble(
    formulation: Formulation,
    constraints: Constraints,
    knots: FloatArray,
    mu: float,
    *,
    sharpness: Mapping[str, FloatArray],
    penalties: Penalties | None = None,
) -> NonlinearProgram:
    """The program at barrier weight `mu`, its structure made around feasible `knots` (M, 3).

    Args:
        sharpness: of an earlier program's smooth minima, see `sharpness_of`.
        penalties: the program restores feasibility by them; its Hessian is the Gauss-Newton one.
    """
    setup = TermSetup(formulation, knots, mu, penalties, sharpness)
    wanted = None if penalties is None else Capability.RESTORING
    exact = penalties is None and formulation.problem.scene.solver.hessian == "exact"
    return NonlinearProgram(
        formulation.layout, build_terms(setup, wanted), constraints, exact, stiffness(formulation)
    )


def stiffness(formulation: Formulation) -> FloatArray:
    """(3 M,) kinetic second derivatives of every variable in order of size, for damping."""
    axes = np.array([1.0, 1.0, formulation.problem.time_scale**2])
    own = formulation.scales.stiffness[formulation.layout.agent_of_knot]
    return (own[:, None] * axes).ravel()


def sharpness_of(terms: Sequence[Term]) -> dict[str, FloatArray]:
    """The sharpness of all smooth minima among `terms`, by their names."""
    found = {term.name: term.sharpness for term in terms}
    return {name: sharpness for name, sharpness in found.items() if sharpness is not None}
