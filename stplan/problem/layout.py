"""Which knot belongs to whom: the indices that every term of the objective shares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import IntArray


@dataclass(frozen=True)
class KnotLayout:
    """Which knot belongs to whom: indices only, shared by every term of the objective.

    Attributes:
        offsets: (A + 1,) agent a owns knots ``offsets[a]:offsets[a + 1]``.
        agent_of_knot: (M,).
        first, last: (A,) an agent's first and last knot.
        segment: (S,) first knot of every segment; the second is the next one.
        agent_of_segment: (S,).
        num_segments: (A,) segments n of every agent.
    """

    offsets: IntArray
    agent_of_knot: IntArray
    first: IntArray
    last: IntArray
    segment: IntArray
    agent_of_segment: IntArray
    num_segments: IntArray

    @staticmethod
    def from_offsets(offsets: IntArray) -> KnotLayout:
        """The layout of `WorldLines.offsets`."""
        counts = np.diff(offsets)
        agent_of_knot = np.repeat(np.arange(len(counts)), counts)
        is_last = np.zeros(int(offsets[-1]), dtype=bool)
        is_last[offsets[1:] - 1] = True
        segment = np.flatnonzero(~is_last)
        return KnotLayout(
            offsets=np.asarray(offsets, dtype=np.int64),
            agent_of_knot=agent_of_knot,
            first=offsets[:-1].copy(),
            last=offsets[1:] - 1,
            segment=segment,
            agent_of_segment=agent_of_knot[segment],
            num_segments=counts - 1,
        )

    @property
    def num_knots(self) -> int:
        """Number of knots M of all agents."""
        return int(self.offsets[-1])

    @property
    def num_agents(self) -> int:
        """Number of agents A."""
        return len(self.first)
