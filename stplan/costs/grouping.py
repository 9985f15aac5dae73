"""Grouping cost: C^G_ab = K^G_ab (d_ab - R_ab)^2   (the paper's grouping equation).

d_ab is the smooth minimum distance of the two rods, over *all* pairs of their segments that weigh in
it: listed friends are never cut by the broad phase, however far apart they are. With D = d - R,
value K D^2, slope 2 K D and second derivative 2 K; the rank-one terms follow as for barriers.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.contact_term import NEGLIGIBLE, ContactList, ContactTerm
from stplan.costs.rods import Rods
from stplan.scene.interactions import Interactions
from stplan.smooth_distance.clearance_barriers import Coefficients
from stplan.smooth_distance.contacts import measure


class Grouping(ContactTerm):
    """Quadratic pull of listed pairs towards touching.

    Args:
        knots: (M, 3) around which the structure is made.
        rods: segments and tails.
        interactions: K^G and R of every pair.
        alpha: sharpness of the smooth minimum, 1/m.
        exact: reserve the dense blocks of the exact Hessian.
    """

    name = "grouping"

    def __init__(
        self,
        knots: FloatArray,
        rods: Rods,
        interactions: Interactions,
        alpha: float,
        *,
        exact: bool = False,
    ) -> None:
        self._rods = rods
        self._interactions = interactions
        self._alpha = alpha
        self._num_agents = len(interactions.grouping)
        own = np.unique(rods.agents)
        members = {int(a): np.flatnonzero(rods.agents == a) for a in own}
        first, second = np.nonzero(np.triu(interactions.grouping))
        # Tails are left out: friends are drawn together on their way, not after one has arrived.
        num_own = len(rods.segments) - len(rods.tail_ends)
        pairs = [
            np.column_stack(
                [grid.ravel() for grid in np.meshgrid(
                    members[int(a)][members[int(a)] < num_own],
                    members[int(b)][members[int(b)] < num_own], indexing="ij")]
            )
            for a, b in zip(first, second, strict=True)
        ]  # fmt: skip
        self._pairs = np.vstack(pairs) if pairs else np.empty((0, 2), dtype=np.int64)
        self._points = np.hstack(
            [rods.segments[self._pairs[:, 0]], rods.segments[self._pairs[:, 1]]]
        )
        self._keys = (
            rods.agents[self._pairs[:, 0]] * self._num_agents + rods.agents[self._pairs[:, 1]]
        )
        typical = float(interactions.distance[interactions.grouping > 0].max(initial=1.0))
        super().__init__(
            num_knots=len(knots),
            axis_scale=np.array([1.0, 1.0, rods.time_scale]),
            skin=typical,
            structure_skin=2 * typical,
            exact_coupling=exact,
        )
        self.start(knots)

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + T, 3) positions of knots and tail ends."""
        return self._rods.positions(knots)

    def find_contacts(self, knots: FloatArray, skin: float) -> ContactList:
        """Pairs of segments that weigh in the minimum now or after moving half a skin each."""
        contacts = ContactList.grouped(self._points, self._keys)
        if not len(self._points):
            return contacts
        distance = measure(self.positions(knots), contacts.points).distance
        least = np.minimum.reduceat(distance, contacts.starts[:-1])
        keep = distance < least[contacts.members] + NEGLIGIBLE / self._alpha + 2 * skin
        return ContactList.grouped(contacts.points[keep], contacts.keys[contacts.members[keep]])

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """Quadratic cost of every group's smooth minimum."""
        slope = np.zeros(len(distance))
        curvature = np.zeros(len(distance))
        majorizer = np.zeros(len(distance))
        coupling = np.zeros(len(contacts.keys))
        total = 0.0
        for g, key in enumerate(contacts.keys):
            a, b = divmod(int(key), self._num_agents)
            weight = self._interactions.grouping[a, b]
            members = slice(int(contacts.starts[g]), int(contacts.starts[g + 1]))
            own = distance[members]
            least = own.min()
            share = np.exp(-self._alpha * (own - least))
            summed = share.sum()
            share /= summed
            gap = least - np.log(summed) / self._alpha - self._interactions.distance[a, b]
            total += weight * gap**2
            slope[members] = 2 * weight * gap * share
            curvature[members] = -2 * weight * gap * self._alpha * share
            majorizer[members] = 2 * weight * share
            coupling[g] = 2 * weight * (1 + gap * self._alpha)
        return Coefficients(total, np.inf, slope, curvature, majorizer, coupling)
