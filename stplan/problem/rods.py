"""The rods of all agents as points and segments in (x, y, c t), with the tails of staying agents."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.problem.layout import KnotLayout


@dataclass(frozen=True)
class FixedRods:
    """Rods of B agents that do not move: stretches of their curves, and where they stand afterwards.

    Attributes:
        points: (F, 3) in (x, y, c t), m.
        segments: (S, 2) indices of points, agent by agent in the order of time.
        agents: (S,) owners, increasing.
        tails: (T, 2) indices of points, one an agent at most.
        tail_agents: (T,) owners, increasing.
        num_segments: (B,) segments of every agent's whole curve.
    """

    points: FloatArray
    segments: IntArray
    agents: IntArray
    tails: IntArray
    tail_agents: IntArray
    num_segments: IntArray

    @staticmethod
    def none() -> FixedRods:
        """No rod."""
        none, nobody = np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)
        return FixedRods(np.empty((0, 3)), none, nobody, none, nobody, nobody)


@dataclass(frozen=True)
class Rods:
    """Segments of the curves, those of fixed rods, then the vertical tails of agents on their goals.

    Agents of fixed rods are numbered after those whose curves have knots.

    Attributes:
        time_scale: c in m/s.
        fixed_points: (F, 3) what never moves, m: upper ends of tails (goal, c * final time), then the points
            of fixed rods.
        segments: (S + T, 2) indices of positions: knots, then fixed points.
        agents: (S + T,) owner of every segment.
        num_segments: (A,) segments of every agent's whole curve.
        num_tails: T.
        num_knots: M; all positions from here on are fixed.
    """

    time_scale: float
    fixed_points: FloatArray
    segments: IntArray
    agents: IntArray
    num_segments: IntArray
    num_tails: int
    num_knots: int

    @staticmethod
    def build(
        layout: KnotLayout,
        knots: FloatArray,
        stays: IntArray,
        final_time: float,
        time_scale: float,
        fixed: FixedRods | None = None,
    ) -> Rods:
        """`stays` lists the agents whose rod goes on until `final_time` (s)."""
        fixed = FixedRods.none() if fixed is None else fixed
        last = layout.last[stays]
        ends = np.column_stack([knots[last, :2], np.full(len(stays), time_scale * final_time)])
        own = np.column_stack([layout.segment, layout.segment + 1])
        tails = np.column_stack([last, layout.num_knots + np.arange(len(stays))])
        points, after = layout.num_knots + len(stays), layout.num_agents
        return Rods(
            time_scale=time_scale,
            fixed_points=np.vstack([ends, fixed.points]),
            segments=np.vstack([own, points + fixed.segments, tails, points + fixed.tails]).astype(
                np.int64
            ),
            agents=np.concatenate(
                [layout.agent_of_segment, after + fixed.agents, stays, after + fixed.tail_agents]
            ).astype(np.int64),
            num_segments=np.append(layout.num_segments, fixed.num_segments),
            num_tails=len(stays) + len(fixed.tails),
            num_knots=layout.num_knots,
        )

    @property
    def num_curve_segments(self) -> int:
        """Segments that are no tails, S: they come first."""
        return len(self.segments) - self.num_tails

    @cached_property
    def moving(self) -> BoolArray | None:
        """(S + T,) which segments may move; None where all may."""
        moving: BoolArray = self.segments.min(axis=1) < self.num_knots
        return None if moving.all() else moving

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + F, 3) in m."""
        return np.vstack([knots * [1.0, 1.0, self.time_scale], self.fixed_points])
