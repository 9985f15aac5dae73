"""A cost of one's own for being somewhere: C_a = w_a int phi(x_a(t)) dt, by the trapezoidal rule over knots.

phi is in J (costs are in J s), so that it weighs against kinetic costs. On a segment from knot i
to j the cost is (t_j - t_i) / 2 (phi(x_i) + phi(x_j)): what is narrower than knots are apart is not seen, and
more `solver.knots` see more. With g and H the gradient and Hessian of phi, the derivatives are

    dC/dx_i = dt/2 g_i,   dC/dt_j = -dC/dt_i = (phi_i + phi_j) / 2,
    d2C/dx_i2 = dt/2 H_i,   d2C/dx_i dt_j = -d2C/dx_i dt_i = g_i / 2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.blocks import block_structure, joined_structure, pack_blocks
from stplan.costs.formulation import TermSetup
from stplan.nlp.term import Capability, Structure, Term
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_frame import PlanningFrame

Field = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class FloorCost:
    """What it costs to be at a place, for `stplan.added_costs`.

    Attributes:
        name: of the cost in reports; none of the program's own.
        value: phi at places (N, 2) in m, as (N,).
        gradient: its derivative as (N, 2).
        hessian: its second derivative as (N, 2, 2), symmetric.
        weights: w of agents by id, 1 where left out.
    """

    name: str
    value: Field
    gradient: Field
    hessian: Field
    weights: Mapping[str, float] = field(default_factory=dict)
    capabilities: Capability = Capability.PRICE

    def build(self, setup: TermSetup) -> FloorTerm:
        """The term of a program, in the coordinates it is planned in."""
        problem = setup.formulation.problem
        weights = [self.weights.get(agent.id, 1.0) for agent in problem.scene.agents]
        return FloorTerm(self, setup.formulation.layout, np.array(weights), problem.frame)


class FloorTerm(Term):
    """A `FloorCost` in a program.

    Args:
        layout: of the knots.
        weights: (A,).
        frame: of the knots; the cost itself is asked in the user's coordinates.
    """

    name = "floor cost"
    capabilities = Capability.PRICE

    def __init__(
        self, cost: FloorCost, layout: KnotLayout, weights: FloatArray, frame: PlanningFrame
    ) -> None:
        self.name = cost.name  # type: ignore[misc]
        self._cost = cost
        self._start = layout.segment
        self._knots = np.arange(layout.num_knots)
        self._frame = frame
        # Of places and times in local units, a cost in them.
        self._factor = weights[layout.agent_of_segment] * frame.time / frame.cost
        self._turn = np.array([[frame.cosine, frame.sine], [-frame.sine, frame.cosine]])

    def _phi(self, knots: FloatArray) -> FloatArray:
        return np.asarray(self._cost.value(self._frame.points(knots[:, :2])), dtype=np.float64)

    def _slope(self, knots: FloatArray) -> FloatArray:
        """(M, 2) by local places."""
        slope = np.asarray(self._cost.gradient(self._frame.points(knots[:, :2])))
        turned: FloatArray = self._frame.length * slope @ self._turn.T
        return turned

    def _curvature(self, knots: FloatArray) -> FloatArray:
        """(M, 2, 2) by local places."""
        bend = np.asarray(self._cost.hessian(self._frame.points(knots[:, :2])))
        turned: FloatArray = self._frame.length**2 * self._turn @ bend @ self._turn.T
        return turned

    def _half(self, knots: FloatArray) -> FloatArray:
        """(S,) half of every segment's weighted duration."""
        return 0.5 * self._factor * (knots[self._start + 1, 2] - knots[self._start, 2])

    def value(self, knots: FloatArray) -> float:
        """The cost."""
        phi = self._phi(knots)
        return float((self._half(knots) * (phi[self._start] + phi[self._start + 1])).sum())

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        phi, slope, half = self._phi(knots), self._slope(knots), self._half(knots)
        first, second = self._start, self._start + 1
        result = np.zeros_like(knots)
        result[first, :2] += half[:, None] * slope[first]
        result[second, :2] += half[:, None] * slope[second]
        mean = 0.5 * self._factor * (phi[first] + phi[second])
        result[second, 2] += mean
        result[first, 2] -= mean
        return result

    def hessian_structure(self) -> Structure:
        """Blocks (i, i), (i+1, i+1) and (i+1, i) of every segment."""
        first, second = self._start, self._start + 1
        return joined_structure([(first, first), (second, second), (second, first)])

    def hessian(self, knots: FloatArray) -> FloatArray:
        """In the order of the structure."""
        half, first, second = self._half(knots), self._start, self._start + 1
        slope, curvature = self._slope(knots), self._curvature(knots)
        rate = (
            0.5 * self._factor[:, None] * slope[first],
            0.5 * self._factor[:, None] * slope[second],
        )
        blocks = np.zeros((3, len(first), 3, 3))
        for block, knot, sign, own in zip(
            blocks[:2], (first, second), (-1.0, 1.0), rate, strict=True
        ):
            block[:, :2, :2] = half[:, None, None] * curvature[knot]
            block[:, :2, 2] = block[:, 2, :2] = sign * own
        # Rows are of the later knot, columns of the earlier one.
        blocks[2, :, :2, 2] = -rate[1]
        blocks[2, :, 2, :2] = rate[0]
        same = [pack_blocks(block, diagonal=True) for block in blocks[:2]]
        return np.concatenate([*same, pack_blocks(blocks[2], diagonal=False)])

    def gauss_newton_structure(self) -> Structure:
        """Diagonal blocks of all knots."""
        return block_structure(self._knots, self._knots)

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """The part of places alone, without its negative curvature: positive semidefinite."""
        half, first = self._half(knots), self._start
        share = np.zeros(len(knots))
        np.add.at(share, first, half)
        np.add.at(share, first + 1, half)
        values, vectors = np.linalg.eigh(self._curvature(knots))
        convex = (vectors * np.maximum(values, 0.0)[:, None, :]) @ vectors.transpose(0, 2, 1)
        blocks = np.zeros((len(knots), 3, 3))
        blocks[:, :2, :2] = share[:, None, None] * convex
        return pack_blocks(blocks, diagonal=True)
