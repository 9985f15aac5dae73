"""Kinetic cost: C^K_a = K^K_a sum_i 1/2 m_a |dx_i|^2 / dt_i   (the paper's kinetic equation).

|dx|^2 / dt is the perspective of a square, so it is convex for dt > 0 and its Hessian is positive
semidefinite: with velocity v = dx / dt the segment's block is m/dt [[I, -v], [-v^T, v.v]].
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.blocks import joined_structure, pack_blocks
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout


@register(rank=10)
class Kinetic(Term):
    """Sum over agents of weight times mass times half the squared speed, integrated over time."""

    name = "kinetic"
    capabilities = Capability.PRICE | Capability.RESTORING

    def __init__(self, layout: KnotLayout, weights: FloatArray, masses: FloatArray) -> None:
        """`weights` K^K (A,), `masses` (A,) in kg."""
        self._layout = layout
        self._start = layout.segment
        self._stiffness = (weights * masses)[layout.agent_of_segment]

    @classmethod
    def build(cls, setup: TermSetup) -> Kinetic:
        """Every scene has it."""
        formulation = setup.formulation
        weights = formulation.weights("kinetic")
        if setup.penalties is not None:
            # Whoever does not mind its motion would be led nowhere.
            weights = formulation.scales.kinetic
        return cls(formulation.layout, weights, formulation.problem.masses)

    def _steps(self, knots: FloatArray) -> tuple[FloatArray, FloatArray]:
        step = knots[self._start + 1] - knots[self._start]
        return step[:, :2], step[:, 2]

    def value(self, knots: FloatArray) -> float:
        """The cost in joule seconds."""
        return float(self.per_agent(knots).sum())

    def per_agent(self, knots: FloatArray) -> FloatArray:
        """The cost of every agent (A,), inf where time does not advance."""
        step, duration = self._steps(knots)
        if not (duration > 0).all():
            return np.full(self._layout.num_agents, np.inf)
        cost = 0.5 * self._stiffness * (step**2).sum(axis=1) / duration
        return np.bincount(self._layout.agent_of_segment, cost, self._layout.num_agents).astype(
            np.float64
        )

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        step, duration = self._steps(knots)
        velocity = step / duration[:, None]
        force = np.empty((len(duration), 3))
        force[:, :2] = self._stiffness[:, None] * velocity
        force[:, 2] = -0.5 * self._stiffness * (velocity**2).sum(axis=1)
        result = np.zeros_like(knots)
        result[self._start + 1] += force
        result[self._start] -= force
        return result

    def hessian_structure(self) -> Structure:
        """Blocks (i, i), (i+1, i+1) and (i+1, i) of every segment."""
        first, second = self._start, self._start + 1
        return joined_structure([(first, first), (second, second), (second, first)])

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Values in the order of the structure; positive semidefinite."""
        step, duration = self._steps(knots)
        velocity = step / duration[:, None]
        blocks = np.zeros((len(duration), 3, 3))
        blocks[:, 0, 0] = blocks[:, 1, 1] = 1.0
        blocks[:, 0, 2] = blocks[:, 2, 0] = -velocity[:, 0]
        blocks[:, 1, 2] = blocks[:, 2, 1] = -velocity[:, 1]
        blocks[:, 2, 2] = (velocity**2).sum(axis=1)
        blocks *= (self._stiffness / duration)[:, None, None]
        same = pack_blocks(blocks, diagonal=True)
        return np.concatenate([same, same, pack_blocks(-blocks, diagonal=False)])

    def gauss_newton_structure(self) -> Structure:
        """That of the Hessian."""
        return self.hessian_structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The exact one, which is positive semidefinite."""
        return self.hessian(knots)
