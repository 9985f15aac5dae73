"""Which segments of two rods weigh in their smooth minimum distance, however far apart they are.

For costs without a reach: the pull of friends, and the paper's logarithm, which has no end.
"""

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
class NearestCandidates:
    """Pairs of segments hardly further apart than the nearest ones of their two rods.

    Attributes:
        rods: segments and tails.
        pairs: (G, 2) agents a < b, sorted.
        num_agents: A.
        sharpness: (G,) alpha, 1/m.
        tails: whether agents are there after they have arrived, too.
        negligible: contacts further than this over alpha beyond the nearest are left out.
    """

    rods: Rods
    pairs: IntArray
    num_agents: int
    sharpness: FloatArray
    tails: bool
    negligible: float = NEGLIGIBLE

    @cached_property
    def axis_scale(self) -> FloatArray:
        """(1, 1, c)."""
        return np.array([1.0, 1.0, self.rods.time_scale])

    @cached_property
    def _segments(self) -> IntArray:
        """(S, 2) segments sorted by agent, in the order of time."""
        return np.ascontiguousarray(self.rods.segments[self._order])

    @cached_property
    def _order(self) -> IntArray:
        agents = self.rods.agents
        if not self.tails:
            agents = agents[: self.rods.num_curve_segments]
        return np.argsort(agents, kind="stable")

    @cached_property
    def _ranges(self) -> IntArray:
        """(G, 4) segments of one and the other rod of every pair."""
        owners = self.rods.agents[self._order]
        begin = np.searchsorted(owners, np.arange(self.num_agents))
        end = np.searchsorted(owners, np.arange(self.num_agents), side="right")
        first, second = self.pairs.T
        return np.column_stack([begin[first], end[first], begin[second], end[second]])

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + T, 3) positions of knots and tail ends."""
        return self.rods.positions(knots)

    def find(self, knots: FloatArray, skin: float) -> ContactList:
        """Pairs of segments that weigh in the minimum now or after moving half a skin each."""
        slack = self.negligible / self.sharpness + 2 * skin
        found, group = near_minimum(self.positions(knots), self._segments, self._ranges, slack)
        points = np.hstack([self._segments[found[:, 0]], self._segments[found[:, 1]]])
        first, second = self.pairs.T
        return ContactList.grouped(points, (first * self.num_agents + second)[group])

    def renew(self, old: ContactSet, knots: FloatArray, moved: BoolArray) -> ContactSet:
        """The whole list anew: it is short."""
        del moved
        return ContactSet.fresh(self, knots, old.skin)
