"""The rods of all agents as points and segments in (x, y, c t), with the tails of staying agents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.problem.layout import KnotLayout


@dataclass(frozen=True)
class Rods:
    """Segments of the curves, then one vertical tail for every agent that stays on its goal.

    Attributes:
        time_scale: c in m/s.
        tail_ends: (T, 3) fixed points (goal, c * final time), m.
        segments: (S + T, 2) indices of positions.
        agents: (S + T,) owner of every segment.
    """

    time_scale: float
    tail_ends: FloatArray
    segments: IntArray
    agents: IntArray

    @staticmethod
    def build(
        layout: KnotLayout,
        knots: FloatArray,
        stays: IntArray,
        final_time: float,
        time_scale: float,
    ) -> Rods:
        """`stays` lists the agents whose rod goes on until `final_time` (s)."""
        last = layout.last[stays]
        ends = np.column_stack([knots[last, :2], np.full(len(stays), time_scale * final_time)])
        own = np.column_stack([layout.segment, layout.segment + 1])
        tails = np.column_stack([last, layout.num_knots + np.arange(len(stays))])
        return Rods(
            time_scale,
            ends,
            np.vstack([own, tails]).astype(np.int64),
            np.concatenate([layout.agent_of_segment, stays]).astype(np.int64),
        )

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + T, 3) in m."""
        return np.vstack([knots * [1.0, 1.0, self.time_scale], self.tail_ends])
