"""World lines: the space-time curves of all agents in one flat array (the paper's s_a)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class WorldLines:
    """Polylines in (x, y, t), one an agent, in scene order.

    Attributes:
        agent_ids: ids, length A.
        offsets: (A + 1,) int64; agent a owns rows ``offsets[a]:offsets[a + 1]`` of `knots`.
        knots: (M, 3) float64, columns x [m], y [m], t [s]; t strictly increases within an agent.
    """

    agent_ids: tuple[str, ...]
    offsets: IntArray
    knots: FloatArray

    @staticmethod
    def from_curves(agent_ids: Sequence[str], curves: Sequence[FloatArray]) -> WorldLines:
        """Join one (n_a + 1, 3) curve an agent; a scene always has at least one agent."""
        offsets = np.concatenate([[0], np.cumsum([len(curve) for curve in curves])])
        knots = np.ascontiguousarray(np.vstack(curves), dtype=np.float64)
        return WorldLines(tuple(agent_ids), offsets.astype(np.int64), knots)

    @property
    def num_agents(self) -> int:
        """Number of agents A."""
        return len(self.agent_ids)

    def curve(self, agent: int) -> FloatArray:
        """The (n_a + 1, 3) knots of one agent, a view."""
        return self.knots[self.offsets[agent] : self.offsets[agent + 1]]

    def curves(self) -> Iterator[FloatArray]:
        """Every agent's curve in scene order."""
        return (self.curve(agent) for agent in range(self.num_agents))

    def with_knots(self, knots: FloatArray) -> WorldLines:
        """The same layout with other knots (M, 3)."""
        return WorldLines(self.agent_ids, self.offsets, knots)
