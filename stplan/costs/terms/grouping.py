"""Grouping cost: C^G_ab = K^G_ab (d_ab - R_ab)^2   (the paper's grouping equation).

d_ab is the smooth minimum distance of the two rods, over all pairs of their segments that weigh in it:
listed friends are never cut by the broad phase, however far apart they are, and only near the nearest
pair are segments looked at one by one.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.contacts.blocks import DenseCoupling, near_blocks
from stplan.costs.contacts.contact_set import ContactSet
from stplan.costs.contacts.contact_term import ContactModel, ContactTerm
from stplan.costs.contacts.nearest_candidates import NearestCandidates
from stplan.costs.contacts.potential import QuadraticPull
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability
from stplan.problem.rods import Rods
from stplan.scene.interactions import Interactions


@register(rank=70)
class Grouping(ContactTerm):
    """Quadratic pull of listed pairs towards touching.

    Args:
        knots: (M, 3) around which the structure is made.
        rods: segments and tails.
        interactions: K^G and R of every pair.
        alpha: sharpness of the smooth minimum, 1/m.
    """

    name = "grouping"
    capabilities = Capability.PRICE | Capability.LIVE | Capability.RESTORING

    def __init__(
        self, knots: FloatArray, rods: Rods, interactions: Interactions, alpha: float
    ) -> None:
        grouping, distance = interactions.grouping, interactions.distance
        pairs = np.column_stack(np.nonzero(np.triu(grouping)))
        # Friends are drawn together on their way, not after one has arrived.
        candidates = NearestCandidates(
            rods, pairs, len(grouping), np.full(len(pairs), alpha), tails=False
        )
        typical = float(distance[grouping > 0].max(initial=1.0))
        wide = candidates.find(knots, 2 * typical)
        super().__init__(
            ContactSet.fresh(candidates, knots, typical),
            ContactModel(
                QuadraticPull(distance.ravel(), grouping.ravel(), alpha),
                partial(near_blocks, wide, len(knots)),
                DenseCoupling(wide, len(knots), dimension=3),
            ),
        )

    @classmethod
    def build(cls, setup: TermSetup) -> Grouping | None:
        """Where a pair is grouped."""
        formulation, problem = setup.formulation, setup.formulation.problem
        if not problem.interactions.grouping.any():
            return None
        alpha = problem.scene.solver.alpha
        return cls(setup.knots, formulation.rods, problem.interactions, alpha)
