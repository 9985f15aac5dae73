"""Scales of a scene: weights of barriers and regularity, and ranges, from every agent's cost on its seed.

An absolute mu or K^R would swamp cheap agents and drown in dear ones, and so would one of all agents
together where one of them is a thousand times as dear as another. With E_a an agent's kinetic cost on its
seed, what it feels of barriers starts at a thousandth of E_a, and K^R_a makes its least regularity cost
K^R n a hundredth.

Where an agent pays much more for being late, or for turning, than for its motion, barriers of that size are
drowned too: iterates would run into the limits of motion and crawl along them. There they start at
a thousandth of all that the agent pays, see `Scales.lead_in`.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import Scales
from stplan.costs.terms.haste import arrival_span
from stplan.costs.terms.kinetic import Kinetic
from stplan.optimize.payments import Payments
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem

# mu of the first outer iteration over E.
MU_SHARE = 1e-3
# K^R n over the agent's E_a.
REGULARITY_SHARE = 1e-2
# E_a is at least this share of all that the agent pays, and of the mean of all: who stands still, or does
# not mind its motion, pays no kinetic cost.
LEAST_SHARE, STANDING_SHARE = 0.1, 1e-6
# Barrier range over the distance R_ab of a pair, and over the radius at walls.
RANGE_SHARE = 0.25


def pair_reaches(problem: PlanningProblem, distance: FloatArray) -> FloatArray:
    """Clearance at which repulsion starts of pairs that keep a `distance`, m, of any shape; alike."""
    barrier_range = problem.scene.solver.barrier_range
    if barrier_range is None:
        return RANGE_SHARE * distance
    return np.full_like(distance, barrier_range)


def derive_scales(
    problem: PlanningProblem,
    layout: KnotLayout,
    knots: FloatArray,
    distance: FloatArray | None = None,
) -> Scales:
    """Scales for `problem` from its seed `knots` (M, 3).

    `distance` (A + B, A + B) is what its agents keep from each other and from those around them, m; the
    problem's own without any.
    """
    scene = problem.scene
    kept = problem.distance if distance is None else distance
    masses, radii = problem.masses, problem.radii
    weights = np.array([agent.weights.kinetic for agent in scene.agents])
    moving = Kinetic(layout, np.ones_like(weights), masses).per_agent(knots)
    span = arrival_span(problem, knots[layout.last, 2])
    paid = Payments(problem, layout, span).paid(knots)
    own = np.maximum(weights * moving, LEAST_SHARE * paid)
    movers = ~problem.prescribed
    energy = float(own[movers].mean()) if own[movers].any() else 1.0
    own = np.where(own > STANDING_SHARE * energy, own, energy)
    automatic = REGULARITY_SHARE * own / layout.num_segments
    regularity = np.array(
        [
            automatic[a] if agent.weights.regularity is None else agent.weights.regularity
            for a, agent in enumerate(scene.agents)
        ]
    )
    durations = knots[layout.last, 2] - knots[layout.first, 2]
    # Who minds its kinetic cost less than E_a is as stiff as if it minded it so much.
    worth = np.where(moving > STANDING_SHARE * energy, own / np.maximum(moving, 1e-300), weights)
    given, barrier_range = scene.solver.mu, scene.solver.barrier_range
    return Scales(
        energy=energy,
        own=own,
        mu=MU_SHARE * energy if given is None else given,
        barrier=np.where(movers, own / energy if given is None else 1.0, 0.0),
        excess=np.maximum(paid / own, 1.0) if given is None else np.ones_like(own),
        regularity=regularity,
        kinetic=np.maximum(weights, worth),
        stiffness=np.maximum(weights, worth) * masses * layout.num_segments / durations,
        pair_reach=pair_reaches(problem, kept),
        wall_reach=RANGE_SHARE * 2 * radii
        if barrier_range is None
        else np.full_like(radii, barrier_range),
        span=span,
    )
