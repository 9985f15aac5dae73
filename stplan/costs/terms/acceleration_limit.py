"""Acceleration limit: |v_{i+1} - v_i| / ((dt_i + dt_{i+1}) / 2) <= a_a, at rest before and after.

v_i is the velocity of segment i, and the time is that between the middles of two segments. Before the first
and after the last knot the agent is at rest, half a segment from the middle of that one: |v| / (dt / 2).
One that starts in motion has its velocity v_0 before the first knot: |v - v_0| / (dt / 2).

With u = v_2 - v_1 and g = 2 / (h_1 + h_2):  w = u g,  dg/dh = -g^2/2,  ddg = g^3/2,
dw = g du + u dg,  ddw = g ddu + du dg^T + dg du^T + u ddg.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.formulation import TermSetup
from stplan.costs.limit import (
    MotionLimit,
    Profile,
    Vectors,
    by_knots,
    limit_profile,
    limit_weights,
    power_vectors,
)
from stplan.costs.registry import register
from stplan.problem.layout import KnotLayout


@register(rank=90)
class AccelerationLimit(MotionLimit):
    """Changes of velocity at inner knots, m/s^2."""

    name = "acceleration limit"

    def __init__(
        self,
        layout: KnotLayout,
        limits: FloatArray,
        profile: Profile,
        weights: FloatArray | None = None,
    ) -> None:
        """`limits` (A,) in m/s^2, inf where an agent has none; `weights` (A,) of agents, 1 by default."""
        inner = np.isfinite(limits[layout.agent_of_knot])
        inner[layout.first] = inner[layout.last] = False
        middle = np.flatnonzero(inner)
        super().__init__(
            np.column_stack([middle - 1, middle, middle + 1]),
            limits[layout.agent_of_knot[middle]],
            profile,
            layout.num_knots,
            limit_weights(layout, weights)[layout.agent_of_knot[middle]],
        )

    @classmethod
    def build(cls, setup: TermSetup) -> AccelerationLimit | None:
        """Where an agent has a `max_acceleration`."""
        limits = setup.formulation.limits("max_acceleration")
        if not np.isfinite(limits).any():
            return None
        formulation = setup.formulation
        return cls(formulation.layout, limits, limit_profile(setup), formulation.scales.barrier)

    def vectors(self, local: FloatArray) -> Vectors:
        """Accelerations."""
        step = np.diff(local, axis=1)
        count = len(step)
        place, time = step[:, :, :2], step[:, :, 2]
        pace = 1.0 / time
        change = place[:, 1] * pace[:, 1:] - place[:, 0] * pace[:, :1]
        rate = 2.0 / time.sum(axis=1)
        by_rate = np.zeros((count, 6))
        by_rate[:, [2, 5]] = (-0.5 * rate**2)[:, None]
        by_rate_twice = np.zeros((count, 6, 6))
        for i in (2, 5):
            for j in (2, 5):
                by_rate_twice[:, i, j] = 0.5 * rate**3
        first = np.zeros((count, 2, 6))
        second = np.zeros((count, 2, 6, 6))
        for k in range(2):
            for s, sign in ((0, -1.0), (1, 1.0)):
                at, when = 3 * s + k, 3 * s + 2
                first[:, k, at] = sign * pace[:, s]
                first[:, k, when] = -sign * place[:, s, k] * pace[:, s] ** 2
                second[:, k, at, when] = second[:, k, when, at] = -sign * pace[:, s] ** 2
                second[:, k, when, when] = 2.0 * sign * place[:, s, k] * pace[:, s] ** 3
        outer = first[:, :, :, None] * by_rate[:, None, None, :]
        second = rate[:, None, None, None] * second + outer + outer.swapaxes(2, 3)
        second += change[:, :, None, None] * by_rate_twice[:, None]
        first = rate[:, None, None] * first + change[:, :, None] * by_rate[:, None, :]
        return Vectors(rate[:, None] * change, *by_knots(first, second))


@register(rank=100)
class RestLimit(MotionLimit):
    """From rest, or motion, to the first segment's velocity and from the last one's to rest, m/s^2."""

    name = "rest limit"

    def __init__(
        self,
        layout: KnotLayout,
        limits: FloatArray,
        profile: Profile,
        weights: FloatArray | None = None,
        velocities: FloatArray | None = None,
    ) -> None:
        """Like `AccelerationLimit`; `velocities` (A, 2) in m/s before the start, 0 by default."""
        chosen = np.flatnonzero(np.isfinite(limits))
        start = np.concatenate([layout.first[chosen], layout.last[chosen] - 1])
        super().__init__(
            np.column_stack([start, start + 1]),
            np.tile(limits[chosen], 2),
            profile,
            layout.num_knots,
            None if weights is None else np.tile(weights[chosen], 2),
        )
        before = np.zeros((2 * len(chosen), 2))
        if velocities is not None:
            before[: len(chosen)] = velocities[chosen]
        self._before = before

    @classmethod
    def build(cls, setup: TermSetup) -> RestLimit | None:
        """Where an agent has a `max_acceleration`."""
        limits = setup.formulation.limits("max_acceleration")
        if not np.isfinite(limits).any():
            return None
        formulation = setup.formulation
        before = [agent.start_velocity or (0.0, 0.0) for agent in formulation.problem.scene.agents]
        return cls(
            formulation.layout, limits, limit_profile(setup), formulation.scales.barrier,
            np.array(before),
        )  # fmt: skip

    def vectors(self, local: FloatArray) -> Vectors:
        """Accelerations."""
        step = local[:, 1] - local[:, 0]
        at_rest = power_vectors(step[:, :2], step[:, 2], 2.0, 2)
        if not self._before.any():
            return at_rest
        # -2 v_0 / h:  by h 2 v_0 / h^2,  -4 v_0 / h^3.
        time = step[:, 2, None]
        first = np.zeros((len(step), 2, 3))
        second = np.zeros((len(step), 2, 3, 3))
        first[:, :, 2] = 2.0 * self._before / time**2
        second[:, :, 2, 2] = -4.0 * self._before / time**3
        moving = Vectors(-2.0 * self._before / time, *by_knots(first, second))
        return Vectors(
            at_rest.value + moving.value,
            at_rest.first + moving.first,
            at_rest.second + moving.second,
        )
