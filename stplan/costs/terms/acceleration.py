"""Acceleration cost: C^A_a = K^A_a sum_i 1/2 theta_i^2   (the paper's acceleration equation).

theta_i is the angle between successive segments u = q_i - q_{i-1} and v = q_{i+1} - q_i, with
q = (x, y, c t): theta = atan2(|u x v|, u.v). With unit vectors U, V, c = U.V, s = sin theta,
p = V - c U, q = U - c V and k = theta / s (smooth at theta = 0, where its series is used),

    d(theta^2/2)/du = -k p / |u|,            d(theta^2/2)/dv = -k q / |v|,
    k' = dk/dc = (c k - 1) / s^2,
    H_uu = [-k' p p^T + k (U p^T + p U^T + c (I - U U^T))] / |u|^2   (H_vv alike with q, V),
    H_uv = -[k' p q^T + k (I - V V^T - U q^T)] / (|u| |v|).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.blocks import joined_structure, pack_blocks
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout

# Below this angle (rad) the series of k and k' are exact to rounding.
_SERIES_ANGLE = 1e-3


@dataclass
class _Turns:
    theta: FloatArray
    cosine: FloatArray
    ratio: FloatArray
    ratio_slope: FloatArray
    unit_u: FloatArray
    unit_v: FloatArray
    length_u: FloatArray
    length_v: FloatArray
    p: FloatArray
    q: FloatArray


@register(rank=30)
class Acceleration(Term):
    """Sum over agents of weight times half the squared turning angle in space-time."""

    name = "acceleration"
    capabilities = Capability.PRICE

    def __init__(self, layout: KnotLayout, weights: FloatArray, time_scale: float) -> None:
        """`weights` K^A (A,), `time_scale` c in m/s."""
        inner = np.ones(layout.num_knots, dtype=bool)
        inner[layout.first] = inner[layout.last] = False
        self._layout = layout
        self._middle = np.flatnonzero(inner & (weights[layout.agent_of_knot] > 0))
        self._weight = weights[layout.agent_of_knot[self._middle]]
        self._scale = np.array([1.0, 1.0, time_scale])

    @classmethod
    def build(cls, setup: TermSetup) -> Acceleration | None:
        """Where an agent has `weights.acceleration`."""
        formulation = setup.formulation
        weights = formulation.weights("acceleration")
        if not weights.any():
            return None
        return cls(formulation.layout, weights, formulation.problem.scene.turning_scale)

    def _turns(self, knots: FloatArray) -> _Turns:
        scaled = knots * self._scale
        u = scaled[self._middle] - scaled[self._middle - 1]
        v = scaled[self._middle + 1] - scaled[self._middle]
        length_u = np.sqrt((u**2).sum(axis=1))
        length_v = np.sqrt((v**2).sum(axis=1))
        unit_u = u / length_u[:, None]
        unit_v = v / length_v[:, None]
        sine = np.sqrt((np.cross(unit_u, unit_v) ** 2).sum(axis=1))
        cosine = (unit_u * unit_v).sum(axis=1)
        theta = np.arctan2(sine, cosine)
        small = theta < _SERIES_ANGLE
        safe = np.where(small, 1.0, sine)
        ratio = np.where(small, 1 + theta**2 / 6, theta / safe)
        slope = np.where(small, -1 / 3 - 2 * theta**2 / 15, (cosine * ratio - 1) / safe**2)
        return _Turns(
            theta, cosine, ratio, slope, unit_u, unit_v, length_u, length_v,
            unit_v - cosine[:, None] * unit_u, unit_u - cosine[:, None] * unit_v,
        )  # fmt: skip

    def value(self, knots: FloatArray) -> float:
        """The cost in square radians."""
        return float(self.per_agent(knots).sum())

    def per_agent(self, knots: FloatArray) -> FloatArray:
        """The cost of every agent (A,)."""
        cost = 0.5 * self._weight * self._turns(knots).theta ** 2
        agents = self._layout.agent_of_knot[self._middle]
        return np.bincount(agents, cost, self._layout.num_agents).astype(np.float64)

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        turns = self._turns(knots)
        by_u = -(self._weight * turns.ratio / turns.length_u)[:, None] * turns.p * self._scale
        by_v = -(self._weight * turns.ratio / turns.length_v)[:, None] * turns.q * self._scale
        result = np.zeros_like(knots)
        result[self._middle - 1] -= by_u
        result[self._middle] += by_u - by_v
        result[self._middle + 1] += by_v
        return result

    def hessian_structure(self) -> Structure:
        """Blocks among the three knots of every turn."""
        before, middle, after = self._middle - 1, self._middle, self._middle + 1
        pairs = [(before, before), (middle, middle), (after, after)]
        pairs += [(middle, before), (after, middle), (after, before)]
        return joined_structure(pairs)

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact second derivatives in the order of the structure."""
        turns = self._turns(knots)
        uu = _own_block(turns, turns.unit_u, turns.length_u, turns.p)
        vv = _own_block(turns, turns.unit_v, turns.length_v, turns.q)
        uv = (
            -(
                turns.ratio_slope[:, None, None] * _outer(turns.p, turns.q)
                + turns.ratio[:, None, None]
                * (np.eye(3) - _outer(turns.unit_v, turns.unit_v) - _outer(turns.unit_u, turns.q))
            )
            / (turns.length_u * turns.length_v)[:, None, None]
        )
        vu = uv.transpose(0, 2, 1)
        scale = self._weight[:, None, None] * np.outer(self._scale, self._scale)
        diagonal = [uu, uu - uv - vu + vv, vv]
        below = [vu - uu, vu - vv, -vu]
        return np.concatenate(
            [pack_blocks(scale * block, diagonal=True) for block in diagonal]
            + [pack_blocks(scale * block, diagonal=False) for block in below]
        )

    def gauss_newton_structure(self) -> Structure:
        """That of the Hessian."""
        return self.hessian_structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The exact one, indefinite as it is: any convex part of it converges much slower."""
        return self.hessian(knots)


def _outer(left: FloatArray, right: FloatArray) -> FloatArray:
    """(N, 3, 3) outer products."""
    return left[:, :, None] * right[:, None, :]


def _own_block(turns: _Turns, unit: FloatArray, length: FloatArray, side: FloatArray) -> FloatArray:
    """H_uu (or H_vv) of every turn, (N, 3, 3)."""
    cross = _outer(unit, side)
    block = -turns.ratio_slope[:, None, None] * _outer(side, side)
    block += turns.ratio[:, None, None] * (
        cross
        + cross.transpose(0, 2, 1)
        + turns.cosine[:, None, None] * (np.eye(3) - _outer(unit, unit))
    )
    return block / (length**2)[:, None, None]
