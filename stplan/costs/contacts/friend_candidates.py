"""Which segments of grouped rods weigh in their distance, however far apart they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.contact_set import ContactList, ContactSet
from stplan.costs.contacts.smooth_minimum import NEGLIGIBLE
from stplan.geometry.nearest_segments import near_minimum
from stplan.problem.rods import Rods


@dataclass(frozen=True)
class FriendCandidates:
    """Pairs of segments hardly further apart than the nearest ones of their two rods.

    Attributes:
        rods: segments and tails.
        pairs: (G, 2) grouped agents a < b, sorted.
        num_agents: A.
        sharpness: alpha, 1/m.
    """

    rods: Rods
    pairs: IntArray
    num_agents: int
    sharpness: float

    @cached_property
    def axis_scale(self) -> FloatArray:
        """(1, 1, c)."""
        return np.array([1.0, 1.0, self.rods.time_scale])

    @cached_property
    def _ranges(self) -> IntArray:
        """(G, 4) segments of one and the other rod of every pair.

        Tails are left out: friends are drawn together on their way, not after one has arrived.
        """
        own = self.rods.agents[: len(self.rods.segments) - len(self.rods.tail_ends)]
        begin = np.searchsorted(own, np.arange(self.num_agents))
        end = np.searchsorted(own, np.arange(self.num_agents), side="right")
        first, second = self.pairs.T
        return np.column_stack([begin[first], end[first], begin[second], end[second]])

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + T, 3) positions of knots and tail ends."""
        return self.rods.positions(knots)

    def find(self, knots: FloatArray, skin: float) -> ContactList:
        """Pairs of segments that weigh in the minimum now or after moving half a skin each."""
        slack = NEGLIGIBLE / self.sharpness + 2 * skin
        found, group = near_minimum(self.positions(knots), self.rods.segments, self._ranges, slack)
        points = np.hstack([self.rods.segments[found[:, 0]], self.rods.segments[found[:, 1]]])
        first, second = self.pairs.T
        return ContactList.grouped(points, (first * self.num_agents + second)[group])

    def renew(self, old: ContactSet, knots: FloatArray, moved: BoolArray) -> ContactSet:
        """The whole list anew: it is short."""
        del moved
        return ContactSet.fresh(self, knots, old.skin)
