"""Collision cost: C^C_ab = -mu K^C_ab log(d_ab - R_ab)   (the paper's collision equation).

d_ab is the distance of two rods in (x, y, c t). Two models of it: `contacts`, the barrier of every close
pair of segments, and `smooth-minimum`, the barrier of the log-sum-exp minimum over them, the paper's.
Both use exact distances of segments, so that nothing passes between samples. A contact weighs the product of
both curves' `segment_shares`, so that more knots make no stronger barrier; what stands on a goal weighs 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.blocks import DenseCoupling, near_blocks
from stplan.costs.contacts.contact_set import Candidates, ContactSet
from stplan.costs.contacts.contact_term import ContactModel, ContactTerm
from stplan.costs.contacts.nearest_candidates import NearestCandidates
from stplan.costs.contacts.passage import rods_stay_apart
from stplan.costs.contacts.potential import (
    ContactBarriers,
    Potential,
    SmoothMinimumBarriers,
)
from stplan.costs.contacts.rod_candidates import BroadPhase, RodCandidates
from stplan.costs.contacts.shares import rod_shares
from stplan.costs.contacts.smooth_minimum import NEGLIGIBLE, SmoothMinimum, weighing_reach
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.geometry.contacts import measure
from stplan.geometry.rod_neighbours import near_segments
from stplan.nlp.term import Capability
from stplan.problem.rods import Rods
from stplan.scene.interactions import Interactions

# Lists reach this much further than the structure: they cost less than what renewing them saves.
LIST_SKIN = 1.5
# Without an end to barriers far pairs have long stretches of about equal distance, and are soft: their
# lists and structure reach this part as far.
ENDLESS_SKIN = 0.1
# The wider a structure, the less often it is made anew, but what is hardly felt costs as much at every
# factorisation. From so many knots on it reaches this part of the skin: rooms of 100 (3412 knots) take 0.09 s
# an iteration instead of 0.115 s, rooms of 200 (7752 knots) 0.28 s instead of 0.39 s.
MANY_KNOTS, NARROW = 3000, 0.2
Felt = Callable[[IntArray, IntArray], FloatArray]


@register(rank=50)
class Collision(ContactTerm):
    """Barriers between the rods of every colliding pair.

    Args:
        knots: (M, 3) around which the structure is made; every rod must be clear there.
        rods: segments and tails.
        interactions: who collides, at which distance, how strongly.
        mu: barrier weight.
        reach: (A, A) clearance in m at which repulsion starts, inf for the unbounded logarithm.
        padding: relative enlargement of all distances.
        felt: what pairs a, b (P,) feel of mu (P,), all of it by default.
        smooth: the smooth minimum, None for the model of contacts.
        sharpness: (A * A,) kept from an earlier program by a A + b, nan where not chosen yet.
        broad_phase: finds near pairs of segments.
    """

    name = "collision"
    capabilities = Capability.CLEARANCE | Capability.LIVE | Capability.RESTORING

    def __init__(
        self,
        knots: FloatArray,
        rods: Rods,
        interactions: Interactions,
        mu: float,
        reach: FloatArray,
        *,
        padding: float = 0.0,
        felt: Felt | None = None,
        smooth: SmoothMinimum | None = None,
        sharpness: FloatArray | None = None,
        broad_phase: BroadPhase = near_segments,
    ) -> None:
        collides = interactions.collides
        self._rods, self._interactions, self._padding = rods, interactions, padding
        self._sharpness: FloatArray | None = None
        # Of thousands of agents each square of all pairs takes more memory than all that is near.
        furthest = interactions.distance * (1 + padding)
        furthest += reach
        candidates: Candidates = RodCandidates(rods, collides, furthest, broad_phase)
        finite = np.isfinite(reach)
        ending = collides if finite.all() else collides & finite
        skin = 0.5 * float(reach.max(where=ending, initial=-np.inf))
        if not np.isfinite(skin):
            widest = (1 + padding) * interactions.distance.max(where=collides, initial=0.0)
            skin = 0.5 * max(1.0, float(widest))
        radius = _Radii(interactions.distance, 1 + padding)
        weight = _Weights(interactions.collision_weight, mu, felt)
        potential: Potential = ContactBarriers(
            radius, weight, reach.ravel(), rod_shares(rods, len(knots))
        )
        curved = candidates
        if smooth is not None:
            every = radius[np.arange(reach.size)]
            kept = np.full(reach.size, np.nan) if sharpness is None else sharpness
            weighing = _Weighing(rods, collides, furthest, broad_phase)
            candidates = weighing.candidates(np.where(np.isnan(kept), smooth.alpha_0, kept))
            near = candidates.find(knots, LIST_SKIN * skin)
            gaps = measure(candidates.positions(knots), near.points).distance
            self._sharpness = smooth.sharpened(kept, near, gaps, every)
            alpha = np.where(np.isnan(self._sharpness), smooth.alpha_0, self._sharpness)
            candidates = weighing.candidates(alpha)
            curved = weighing.candidates(alpha, smooth.curved)
            potential = SmoothMinimumBarriers(
                every, weight, reach.ravel(), alpha, cutoff=smooth.cutoff
            )
        endless = smooth is not None and not np.isfinite(reach[collides]).all()
        room = ENDLESS_SKIN * skin if endless else skin
        part = NARROW if len(knots) >= MANY_KNOTS else 1.0
        coupling = None
        if smooth is not None:
            coupling = DenseCoupling(candidates.find(knots, skin), len(knots), dimension=3)
        super().__init__(
            ContactSet.fresh(candidates, knots, LIST_SKIN * room),
            ContactModel(
                potential,
                lambda: near_blocks(curved.find(knots, part * room), len(knots)),
                coupling,
            ),
        )

    @classmethod
    def build(cls, setup: TermSetup) -> Collision | None:
        """Where a pair collides, at distances with the formulation's padding."""
        formulation = setup.formulation
        interactions = formulation.interactions
        if not interactions.collides.any():
            return None
        scales = formulation.scales
        return cls(
            setup.knots, formulation.rods, interactions, setup.mu, scales.pair_reach,
            padding=formulation.padding, felt=scales.pair_barrier,
            smooth=formulation.smooth_minimum, sharpness=setup.sharpness.get(cls.name),
        )  # fmt: skip

    @property
    def sharpness(self) -> FloatArray | None:
        """(A * A,) 1/m of every pair met so far by a A + b, nan elsewhere."""
        return self._sharpness

    def allows_step(self, start: FloatArray, end: FloatArray) -> bool:
        """Whether no two rods pass through each other between the two."""
        return rods_stay_apart(self._rods, start, end, self._interactions.collides, self._kept)

    @cached_property
    def _kept(self) -> FloatArray:
        """(A, A) m."""
        return self._interactions.distance * (1 + self._padding)


@dataclass(frozen=True)
class _Radii:
    """The distances that pairs keep, m, by key a A + b: `distance` (A, A) times a factor."""

    distance: FloatArray
    factor: float

    def __getitem__(self, keys: IntArray) -> FloatArray:
        return self.distance[np.divmod(keys, len(self.distance))] * self.factor


@dataclass(frozen=True)
class _Weights:
    """Factors of pairs' barriers by key a A + b: K^C (A, A), times what they feel of mu."""

    weight: FloatArray
    mu: float
    felt: Felt | None

    def __getitem__(self, keys: IntArray) -> FloatArray:
        pairs = np.divmod(keys, len(self.weight))
        weight = self.weight[pairs]
        return self.mu * (weight if self.felt is None else weight * self.felt(*pairs))


@dataclass(frozen=True)
class _Weighing:
    """Who weighs in smooth minima.

    Attributes:
        reach: (A, A) m, where a pair's barrier begins; inf for the logarithm without an end, which only
            the nearest segments weigh in, however far they are.
    """

    rods: Rods
    collides: BoolArray
    reach: FloatArray
    broad_phase: BroadPhase

    def candidates(self, alpha: FloatArray, negligible: float = NEGLIGIBLE) -> Candidates:
        """Contacts up to `negligible` over `alpha` (A * A,) in 1/m beyond the nearest of their pair."""
        num_agents = len(self.reach)
        # Sharpness is kept for a < b; the broad phase asks in either order.
        if not np.isfinite(self.reach[self.collides]).all():
            pairs = np.column_stack(np.nonzero(np.triu(self.collides)))
            own = alpha[pairs[:, 0] * num_agents + pairs[:, 1]]
            return NearestCandidates(
                self.rods, pairs, num_agents, own, tails=True, negligible=negligible
            )
        segments = np.bincount(self.rods.agents, minlength=num_agents).astype(np.float64)
        counts = np.outer(segments, segments)
        further = weighing_reach(counts, alpha.reshape(num_agents, num_agents), negligible)
        further = np.triu(further) + np.triu(further, 1).T
        return RodCandidates(
            self.rods, self.collides, self.reach + further, self.broad_phase, alpha, negligible
        )
