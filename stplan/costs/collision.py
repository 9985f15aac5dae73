"""Collision cost: C^C_ab = -mu K^C_ab log(d_ab - R_ab)   (the paper's collision equation).

d_ab is the distance of two rods in (x, y, c t). Two models of it: `contacts`, the barrier of every close
pair of segments, and `smooth-minimum`, the barrier of the log-sum-exp minimum over them, the paper's.
Both use exact distances of segments, so that nothing passes between samples.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.clearance_barriers import (
    Coefficients,
    contact_barriers,
    smooth_minimum_barriers,
)
from stplan.costs.contacts.contact_term import ContactList, ContactTerm, sharpened
from stplan.geometry.contacts import measure
from stplan.geometry.rod_neighbours import near_segments
from stplan.problem.rods import Rods
from stplan.scene.interactions import Interactions

# Lists reach this much further than the structure: they cost less than what renewing them saves.
LIST_SKIN = 1.5
# Past this share of moved knots the list is made anew, which costs less than to mend it.
MANY = 0.3


class Collision(ContactTerm):
    """Barriers between the rods of every colliding pair.

    Args:
        knots: (M, 3) around which the structure is made; every rod must be clear there.
        rods: segments and tails.
        interactions: who collides, at which distance, how strongly.
        mu: barrier weight.
        reach: (A, A) clearance in m at which repulsion starts, inf for the unbounded logarithm.
        alpha_0: sharpness in 1/m of the smooth minimum, None for the model of contacts.
        exact: reserve what the exact Hessian of the smooth minimum needs.
        alphas: (A, A) sharpness kept from an earlier run, nan where not chosen yet.
    """

    name = "collision"

    def __init__(
        self,
        knots: FloatArray,
        rods: Rods,
        interactions: Interactions,
        mu: float,
        reach: FloatArray,
        *,
        alpha_0: float | None = None,
        exact: bool = False,
        alphas: FloatArray | None = None,
        skin: float | None = None,
    ) -> None:
        self._rods = rods
        self._interactions = interactions
        self._reach = reach
        self._alpha_0 = alpha_0
        self._num_agents = len(reach)
        self._finite = bool(np.isfinite(reach[interactions.collides]).all())
        self._alphas = np.full_like(reach, np.nan) if alphas is None else alphas
        self._weights = mu * interactions.collision_weight
        felt = reach[interactions.collides & np.isfinite(reach)]
        widest = float(interactions.distance[interactions.collides].max(initial=1.0))
        own_skin = 0.5 * (float(felt.max()) if len(felt) else widest)
        chosen = own_skin if skin is None else skin
        super().__init__(
            num_knots=len(knots),
            axis_scale=np.array([1.0, 1.0, rods.time_scale]),
            skin=LIST_SKIN * chosen,
            structure_skin=chosen,
            exact_coupling=exact and alpha_0 is not None,
        )
        self.start(knots)

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + T, 3) positions of knots and tail ends."""
        return self._rods.positions(knots)

    def find_contacts(self, knots: FloatArray, skin: float) -> ContactList:
        """Pairs of segments nearer than distance, reach and skin together."""
        positions = self.positions(knots)
        self._pairs = self._near(positions, skin)
        contacts = self._contacts_of(self._pairs)
        if self._alpha_0 is not None and len(contacts.points):
            pair = np.divmod(contacts.keys, self._num_agents)
            contacts = sharpened(
                contacts, measure(positions, contacts.points).distance, skin,
                self._interactions.distance[pair], self._alpha_0, self._alphas, pair,
            )  # fmt: skip
        return contacts

    def renew_contacts(self, knots: FloatArray, moved: BoolArray) -> tuple[FloatArray, ContactList]:
        """Only those around knots that have `moved`: mostly few slide far along their own rods.

        Everybody stays within half a skin of the place that the list knows, so it misses nobody.
        """
        if self._alpha_0 is not None or not self._finite or moved.mean() > MANY:
            return super().renew_contacts(knots, moved)
        listed_at = np.where(moved[:, None], knots, self._listed_at)
        # Ends of tails never move.
        ends = np.append(moved, np.zeros(len(self._rods.tail_ends), dtype=bool))
        touched: BoolArray = ends[self._rods.segments].max(axis=1)
        kept = self._pairs[~touched[self._pairs].max(axis=1)]
        found = self._near(self.positions(listed_at), self._skin, touched)
        pairs = np.vstack([kept, found])
        self._pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        return listed_at, self._contacts_of(self._pairs)

    def _near(self, positions: FloatArray, skin: float, asked: BoolArray | None = None) -> IntArray:
        rods, interactions = self._rods, self._interactions
        if not self._finite:
            return all_pairs(rods.agents, interactions.collides)
        reach = interactions.distance + self._reach + skin
        return near_segments(
            positions, rods.segments, rods.agents, interactions.collides, reach, asked
        )

    def _contacts_of(self, pairs: IntArray) -> ContactList:
        first, second = self._rods.agents[pairs[:, 0]], self._rods.agents[pairs[:, 1]]
        points = np.hstack([self._rods.segments[pairs[:, 0]], self._rods.segments[pairs[:, 1]]])
        return ContactList.grouped(points, first * self._num_agents + second)

    @property
    def alphas(self) -> FloatArray:
        """(A, A) sharpness of every pair met so far, nan elsewhere."""
        return self._alphas

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """Barriers of contacts, or of every pair's smooth minimum."""
        first, second = np.divmod(contacts.keys, self._num_agents)
        radius = self._interactions.distance[first, second]
        weight = self._weights[first, second]
        reach = self._reach[first, second]
        if self._alpha_0 is None:
            members = contacts.members
            return contact_barriers(distance, radius[members], weight[members], reach[members])
        return smooth_minimum_barriers(
            distance, contacts.starts, self._alphas[first, second], radius, weight, reach
        )


def all_pairs(agents: IntArray, wanted: BoolArray) -> IntArray:
    """(N, 2) every pair of segments of agents a < b with wanted[a, b]; quadratic, for small scenes."""
    i, j = np.triu_indices(len(agents), 1)
    i, j = np.where(agents[i] <= agents[j], i, j), np.where(agents[i] <= agents[j], j, i)
    keep = (agents[i] != agents[j]) & wanted[agents[i], agents[j]]
    return np.column_stack([i[keep], j[keep]])
