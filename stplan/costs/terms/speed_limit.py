"""Speed limit: |dx_i / dt_i| <= v_a for every segment of an agent with a `max_speed`."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import TermSetup
from stplan.costs.limit import (
    MotionLimit,
    Profile,
    Vectors,
    limit_profile,
    limit_weights,
    power_vectors,
)
from stplan.costs.registry import register
from stplan.problem.layout import KnotLayout


@register(rank=80)
class SpeedLimit(MotionLimit):
    """Velocities of segments, m/s."""

    name = "speed limit"

    def __init__(
        self,
        layout: KnotLayout,
        limits: FloatArray,
        profile: Profile,
        weights: FloatArray | None = None,
    ) -> None:
        """`limits` (A,) in m/s, inf where an agent has none; `weights` (A,) of agents, 1 by default."""
        limit = limits[layout.agent_of_segment]
        chosen = np.isfinite(limit)
        start = layout.segment[chosen]
        super().__init__(
            np.column_stack([start, start + 1]), limit[chosen], profile, layout.num_knots,
            limit_weights(layout, weights)[layout.agent_of_segment[chosen]],
        )  # fmt: skip

    @classmethod
    def build(cls, setup: TermSetup) -> SpeedLimit | None:
        """Where an agent has a `max_speed`."""
        limits = setup.formulation.limits("max_speed")
        if not np.isfinite(limits).any():
            return None
        formulation = setup.formulation
        return cls(formulation.layout, limits, limit_profile(setup), formulation.scales.barrier)

    def vectors(self, local: FloatArray) -> Vectors:
        """Velocities."""
        step = local[:, 1] - local[:, 0]
        return power_vectors(step[:, :2], step[:, 2], 1.0, 1)
