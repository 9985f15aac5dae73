"""Wished clearances: C^W = K^W (E / n_0) sum_k w_k ((s - z_k) / s)^3 over contacts of clearance z_k < s.

`radius` and `distance` have to be kept; a wish s beyond them costs where it is missed, and nothing where
it is met. The cube is twice differentiable at z = s. With E the mean kinetic cost of the seed's agents,
and w_k and n_0 as for barriers, K^W E is about what an agent pays that touches somebody all the way. Of
a pair the greater wish counts, unless the pair has its own, and the mean of both weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.costs.contacts.blocks import near_blocks, own_blocks
from stplan.costs.contacts.contact_set import ContactList, ContactSet
from stplan.costs.contacts.contact_term import ContactModel, ContactTerm
from stplan.costs.contacts.potential import Coefficients
from stplan.costs.contacts.rod_candidates import RodCandidates
from stplan.costs.contacts.shares import REFERENCE_SEGMENTS, knot_shares, rod_shares
from stplan.costs.contacts.wall_candidates import WallCandidates
from stplan.costs.formulation import Formulation, TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability
from stplan.problem.rods import Rods
from stplan.scene.interactions import pair_clearances

# Lists reach this much further than the structure, in parts of the greatest wish.
SKIN, LIST_SKIN = 0.5, 0.75


@dataclass(frozen=True)
class WishedClearance:
    """weight ((s - z) / s)^3 of every contact with z = D - R < s; all by key of its group.

    Attributes:
        radius: R, m.
        weight: factor.
        wish: s, m; 0 where there is none.
        shares: (P,) weight of a contact's curve by its second position, 1 for what is no curve.
    """

    radius: FloatArray
    weight: FloatArray
    wish: FloatArray
    shares: FloatArray

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """The sum over contacts."""
        of = contacts.keys[contacts.members]
        wish = np.where(self.wish[of] > 0.0, self.wish[of], 1.0)
        missing = np.maximum((self.radius[of] + self.wish[of] - distance) / wish, 0.0)
        missing[self.wish[of] <= 0.0] = 0.0
        weight = (
            self.weight[of]
            * self.shares[contacts.points[:, 1]]
            * self.shares[contacts.points[:, 3]]
        )
        curvature = 6.0 * weight * missing / wish**2
        return Coefficients(
            value=float((weight * missing**3).sum()),
            least=np.inf,
            slope=-3.0 * weight * missing**2 / wish,
            curvature=curvature,
            majorizer=curvature,
            coupling=np.zeros(len(contacts.keys)),
        )


@register(rank=80)
class PairClearance(ContactTerm):
    """Wished clearances between the rods of colliding pairs.

    Args:
        knots: (M, 3) around which the structure is made.
        rods: segments and tails.
        collides: (A, A).
        distance: (A, A) R, m.
        wish: (A, A) m beyond R, 0 where there is none.
        weight: (A, A) factor of a pair's sum, J s.
        shares: (P,) weight of a contact's curve by the position its segment ends at.
    """

    name = "pair clearance"
    capabilities = Capability.PRICE | Capability.LIVE

    def __init__(
        self,
        knots: FloatArray,
        rods: Rods,
        collides: BoolArray,
        distance: FloatArray,
        wish: FloatArray,
        weight: FloatArray,
        shares: FloatArray,
    ) -> None:
        candidates = RodCandidates(rods, collides & (wish > 0.0), distance + wish)
        widest = float(wish.max())
        super().__init__(
            ContactSet.fresh(candidates, knots, LIST_SKIN * widest),
            ContactModel(
                WishedClearance(distance.ravel(), weight.ravel(), wish.ravel(), shares),
                lambda: near_blocks(candidates.find(knots, SKIN * widest), len(knots)),
            ),
        )

    @classmethod
    def build(cls, setup: TermSetup) -> PairClearance | None:
        """Where a pair wishes for some."""
        formulation, around = setup.formulation, setup.formulation.surroundings
        interactions, own = formulation.interactions, formulation.weights("clearance")
        if around is None:
            wish = pair_clearances(formulation.problem.scene)
        else:
            wish, own = around.wish, np.append(own, around.clearance_weights)
        if wish is None or not (interactions.collides & (wish > 0.0)).any():
            return None
        weight = 0.5 * (own[:, None] + own[None, :]) * _unit(formulation)
        return cls(
            setup.knots, formulation.rods, interactions.collides, interactions.distance, wish,
            weight, rod_shares(formulation.rods, len(setup.knots)),
        )  # fmt: skip


@register(rank=90)
class WallClearance(ContactTerm):
    """Wished clearances to the boundary of the free space.

    Args:
        knots: (M, 3) around which contacts are found.
        candidates: reaching as far as radius and wish.
        radii: (A,) m.
        wish: (A,) m beyond the radius, 0 where there is none.
        weight: (A,) factor of an agent's sum, J s.
        shares: (P,) weight of a contact's curve by its second position, 1 for corners.
    """

    name = "wall clearance"
    capabilities = Capability.PRICE | Capability.LIVE

    def __init__(
        self,
        knots: FloatArray,
        candidates: WallCandidates,
        radii: FloatArray,
        wish: FloatArray,
        weight: FloatArray,
        shares: FloatArray,
    ) -> None:
        super().__init__(
            ContactSet.fresh(candidates, knots, LIST_SKIN * float(wish.max())),
            ContactModel(
                WishedClearance(radii, weight, wish, shares),
                partial(own_blocks, candidates.segments, len(knots)),
            ),
        )

    @classmethod
    def build(cls, setup: TermSetup) -> WallClearance | None:
        """Where there is a map, and an agent that wishes for clearance and minds walls."""
        formulation, problem = setup.formulation, setup.formulation.problem
        wish = np.array([agent.clearance for agent in problem.scene.agents])
        wish[problem.prescribed | ~problem.heeds_walls] = 0.0
        if problem.free_space is None or problem.boundary is None or not wish.any():
            return None
        layout, free_space = formulation.layout, problem.free_space
        candidates = WallCandidates(
            layout, layout.segment[wish[layout.agent_of_segment] > 0.0],
            free_space.boundary_vertices, free_space.boundary_edges, problem.radii + wish,
            problem.boundary,
        )  # fmt: skip
        return cls(
            setup.knots, candidates, problem.radii, wish,
            formulation.weights("clearance") * _unit(formulation),
            knot_shares(layout, len(free_space.boundary_vertices)),
        )  # fmt: skip


def _unit(formulation: Formulation) -> float:
    """What a contact costs that has none of the wished clearance, for a weight of 1, J s."""
    return formulation.scales.energy / REFERENCE_SEGMENTS
