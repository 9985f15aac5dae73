"""Grouping cost: C^G_ab = K^G_ab (d_ab - R_ab)^2   (the paper's grouping equation).

d_ab is the smooth minimum distance of the two rods, over all pairs of their segments that weigh in it:
listed friends are never cut by the broad phase, however far apart they are, and only near the nearest
pair are segments looked at one by one. With D = d - R, value K D^2, slope 2 K D and second derivative
2 K; the rank-one terms follow as for barriers.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.contacts.clearance_barriers import Coefficients
from stplan.costs.contacts.contact_term import NEGLIGIBLE, ContactList, ContactTerm
from stplan.geometry.nearest_segments import near_minimum
from stplan.problem.rods import Rods
from stplan.scene.interactions import Interactions


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
        first, second = np.nonzero(np.triu(interactions.grouping))
        self._keys = first * self._num_agents + second
        # Tails are left out: friends are drawn together on their way, not after one has arrived.
        own = rods.agents[: len(rods.segments) - len(rods.tail_ends)]
        begin = np.searchsorted(own, np.arange(self._num_agents))
        end = np.searchsorted(own, np.arange(self._num_agents), side="right")
        self._ranges = np.column_stack([begin[first], end[first], begin[second], end[second]])
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
        slack = NEGLIGIBLE / self._alpha + 2 * skin
        pairs, group = near_minimum(self.positions(knots), self._rods.segments, self._ranges, slack)
        points = np.hstack([self._rods.segments[pairs[:, 0]], self._rods.segments[pairs[:, 1]]])
        return ContactList.grouped(points, self._keys[group])

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """Quadratic cost of every group's smooth minimum."""
        if not len(distance):
            nothing = np.zeros(0)
            return Coefficients(0.0, np.inf, nothing, nothing, nothing, nothing)
        starts, members = contacts.starts[:-1], contacts.members
        first, second = np.divmod(contacts.keys, self._num_agents)
        weight = self._interactions.grouping[first, second]
        least = np.minimum.reduceat(distance, starts)
        share = np.exp(-self._alpha * (distance - least[members]))
        summed = np.add.reduceat(share, starts)
        share /= summed[members]
        smooth = least - np.log(summed) / self._alpha
        gap = smooth - self._interactions.distance[first, second]
        slope = (2 * weight * gap)[members] * share
        return Coefficients(
            value=float((weight * gap**2).sum()),
            least=np.inf,
            slope=slope,
            curvature=-self._alpha * slope,
            majorizer=(2 * weight)[members] * share,
            coupling=2 * weight * (1 + gap * self._alpha),
        )
