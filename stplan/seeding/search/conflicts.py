"""Curves of all agents, and the pairs that touch, kept up to date as curves are exchanged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.geometry.rod_distances import rod_distance
from stplan.seeding.search.planner import NO_BLOCKS, Blocks, LayeredPlanner

# Rods that are exactly as far apart as required count as touching, whatever the rounding: a little further
# than where verification calls them clear, a little less far than reservations keep them off.
CONFLICTING = 1.0 + 2e-9


class CurveSet:
    """One curve an agent; agents without one conflict with nobody.

    Attributes:
        curves: (n, 3) world lines, None where an agent has none.
        conflicts: (A, A) pairs whose rods are not further apart than required.
    """

    def __init__(self, planner: LayeredPlanner) -> None:
        count = planner.problem.num_agents
        self.planner = planner
        self.curves: list[FloatArray | None] = [None] * count
        self.conflicts: BoolArray = np.zeros((count, count), dtype=bool)
        self._rods: list[FloatArray] = [np.empty((0, 3))] * count
        self._blocks: list[Blocks | None] = [None] * count
        # Least and greatest x, y of every rod.
        self._low = np.full((count, 2), np.inf)
        self._high = np.full((count, 2), -np.inf)

    def copy(self) -> CurveSet:
        """A copy that shares curves (never changed in place) and nothing else."""
        other = CurveSet.__new__(CurveSet)
        other.planner = self.planner
        other.curves = list(self.curves)
        other.conflicts = self.conflicts.copy()
        other._rods = list(self._rods)
        other._blocks = list(self._blocks)
        other._low = self._low.copy()
        other._high = self._high.copy()
        return other

    @property
    def num_conflicts(self) -> int:
        """Number of conflicting pairs."""
        return int(self.conflicts.sum()) // 2

    def put(self, agent: int, curve: FloatArray | None) -> None:
        """Give `agent` another curve, or none."""
        self.curves[agent] = curve
        self._blocks[agent] = None
        self.conflicts[agent] = False
        if curve is None:
            self._rods[agent] = np.empty((0, 3))
            self._low[agent], self._high[agent] = np.inf, -np.inf
        else:
            self._rods[agent] = self.planner.problem.rod(agent, curve)
            self._low[agent] = curve[:, :2].min(axis=0)
            self._high[agent] = curve[:, :2].max(axis=0)
            for other in self._near(agent, 1.0):
                required = float(self.planner.required.rods[agent, other])
                gap = rod_distance(self._rods[agent], self._rods[other], 1.01 * required)
                self.conflicts[agent, other] = gap <= required * CONFLICTING
        self.conflicts[:, agent] = self.conflicts[agent]

    def nearest(self, agent: int, count: int, reach: float) -> list[int]:
        """Up to `count` agents whose rods come nearest, within `reach` times what is required."""
        found = []
        for other in self._near(agent, reach):
            limit = reach * float(self.planner.required.rods[agent, other])
            gap = rod_distance(self._rods[agent], self._rods[other], limit)
            if gap < limit:
                found.append((gap, int(other)))
        return [other for _, other in sorted(found)[:count]]

    def blocks(self, agent: int) -> Blocks:
        """What the agent's rod blocks, found once."""
        known = self._blocks[agent]
        if known is None:
            curve = self.curves[agent]
            known = (
                (NO_BLOCKS,) * len(self.planner.class_distance)
                if curve is None
                else self.planner.blocks(agent, curve)
            )
            self._blocks[agent] = known
        return known

    def all_curves(self) -> list[FloatArray]:
        """The curves, once every agent has one."""
        return [curve for curve in self.curves if curve is not None]

    def _near(self, agent: int, reach: float) -> Sequence[int]:
        """Agents that collide with `agent` and whose boxes come within `reach` x the distance."""
        limit = reach * self.planner.required.rods[agent]
        near = (
            self.planner.problem.collides[agent]
            & (self._low[agent] <= self._high + limit[:, None]).all(axis=1)
            & (self._low <= self._high[agent] + limit[:, None]).all(axis=1)
        )
        return [int(other) for other in np.flatnonzero(near)]
