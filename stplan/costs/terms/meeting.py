"""Meetings: |p_i - p_j| <= within for the two knots at which a pair meets.

That both are reached at one time is not this term's business: the problem keeps t_i = t_j as a linear
constraint.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.formulation import TermSetup
from stplan.costs.limit import MotionLimit, Profile, Vectors, limit_profile
from stplan.costs.registry import register


@register(rank=110)
class MeetingLimit(MotionLimit):
    """Distances of pairs at their meetings, m."""

    name = "meeting"

    def __init__(
        self,
        links: IntArray,
        within: FloatArray,
        profile: Profile,
        num_knots: int,
        weights: FloatArray | None = None,
    ) -> None:
        """`links` (L, 2) knots i < j of different agents, `within` (L,) in m, `weights` (L,) or all 1."""
        super().__init__(links, within, profile, num_knots, weights)

    @classmethod
    def build(cls, setup: TermSetup) -> MeetingLimit | None:
        """Where a pair has to meet."""
        formulation = setup.formulation
        timed = formulation.timed
        if not len(timed.links):
            return None
        layout = formulation.layout
        first, second = layout.agent_of_knot[timed.links].T
        weights = formulation.scales.pair_barrier(first, second)
        return cls(timed.links, timed.within, limit_profile(setup), layout.num_knots, weights)

    def vectors(self, local: FloatArray) -> Vectors:
        """Relative positions."""
        count = len(local)
        first = np.zeros((count, 2, 6))
        for k in range(2):
            first[:, k, k] = -1.0
            first[:, k, 3 + k] = 1.0
        return Vectors(local[:, 1, :2] - local[:, 0, :2], first, np.zeros((count, 2, 6, 6)))
