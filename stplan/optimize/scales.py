"""Scales of a scene: barrier weight, regularity weight and barrier range from the seed's own cost.

An absolute mu or K^R would swamp cheap agents and drown in dear ones. With E the mean kinetic cost of the
seed's agents, mu starts at a thousandth of E, and K^R_a makes the least regularity cost K^R n a
hundredth of the agent's own kinetic cost.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import Scales
from stplan.costs.terms.kinetic import Kinetic
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem

# mu of the first outer iteration over E.
MU_SHARE = 1e-3
# K^R n over the agent's kinetic cost.
REGULARITY_SHARE = 1e-2
# Agents that mind their kinetic cost less than this are as stiff as if they minded it so much.
LEAST_WEIGHT = 1e-3
# Barrier range over the distance R_ab of a pair, and over the radius at walls.
RANGE_SHARE = 0.25


def derive_scales(problem: PlanningProblem, layout: KnotLayout, knots: FloatArray) -> Scales:
    """Scales for `problem` from its seed `knots` (M, 3)."""
    scene, interactions = problem.scene, problem.interactions
    masses, radii = problem.masses, problem.radii
    weights = np.array([agent.weights.kinetic for agent in scene.agents])
    own = Kinetic(layout, weights, masses).per_agent(knots)
    energy = float(own.mean())
    if energy <= 0.0:
        energy = 1.0
    # An agent that need not move still gets a regularity of the scene's scale.
    typical = np.where(own > 1e-3 * energy, own, energy)
    automatic = REGULARITY_SHARE * typical / layout.num_segments
    regularity = np.array(
        [
            automatic[a] if agent.weights.regularity is None else agent.weights.regularity
            for a, agent in enumerate(scene.agents)
        ]
    )
    durations = knots[layout.last, 2] - knots[layout.first, 2]
    given = scene.solver.barrier_range
    return Scales(
        energy=energy,
        mu=MU_SHARE * energy if scene.solver.mu is None else scene.solver.mu,
        regularity=regularity,
        stiffness=np.maximum(weights, LEAST_WEIGHT) * masses * layout.num_segments / durations,
        pair_reach=RANGE_SHARE * interactions.distance
        if given is None
        else np.full_like(interactions.distance, given),
        wall_reach=RANGE_SHARE * 2 * radii if given is None else np.full_like(radii, given),
    )
