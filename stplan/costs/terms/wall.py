"""Wall cost: C^M_a = -mu K^M_a log(d_a - r_a), d_a in the plane   (the paper's map equation).

Distances of a curve to the boundary are taken knot to edge and corner to segment: together they are the
distance of the two polylines wherever the curve does not cross the boundary, and unlike segment against
segment they do not jump along parallel walls. Crossings are refused separately: the cost is inf there.
A contact weighs its curve's `segment_shares`, so that more knots make no stronger barrier.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.contacts.blocks import DenseCoupling, own_blocks
from stplan.costs.contacts.contact_set import ContactSet
from stplan.costs.contacts.contact_term import ContactModel, ContactTerm
from stplan.costs.contacts.passage import walls_stay_clear
from stplan.costs.contacts.potential import (
    ContactBarriers,
    Potential,
    SmoothMinimumBarriers,
)
from stplan.costs.contacts.shares import knot_shares
from stplan.costs.contacts.smooth_minimum import SmoothMinimum, weighing_reach
from stplan.costs.contacts.wall_candidates import EdgeSearch, WallCandidates
from stplan.costs.formulation import TermSetup
from stplan.costs.registry import register
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.contacts import measure
from stplan.geometry.crossings import crossings
from stplan.nlp.term import Capability
from stplan.problem.layout import KnotLayout


@register(rank=60)
class Wall(ContactTerm):
    """Barriers between curves and the boundary of the free space.

    Args:
        knots: (M, 3) around which contacts are found; every curve must be clear there.
        layout: knots and agents.
        boundary: its grid of edges.
        boundary_vertices: (B, 2) m.
        boundary_edges: (E, 2) indices.
        radii: (A,) r_a, m.
        weights: (A,) K^M; 0 switches an agent's walls off.
        mu: barrier weight.
        reach: (A,) clearance in m at which repulsion starts, inf for the unbounded logarithm.
        smooth: the smooth minimum, None for the model of contacts.
        sharpness: (A,) kept from an earlier program, nan where not chosen yet.
        search: finds near edges, the grid by default.
    """

    name = "wall"
    capabilities = Capability.CLEARANCE | Capability.LIVE | Capability.RESTORING

    def __init__(
        self,
        knots: FloatArray,
        layout: KnotLayout,
        boundary: BoundaryGrid,
        boundary_vertices: FloatArray,
        boundary_edges: IntArray,
        radii: FloatArray,
        weights: FloatArray,
        mu: float,
        reach: FloatArray,
        *,
        smooth: SmoothMinimum | None = None,
        sharpness: FloatArray | None = None,
        search: EdgeSearch | None = None,
    ) -> None:
        self._boundary = boundary
        heeds = weights[layout.agent_of_segment] > 0
        self._segments = layout.segment[heeds]
        self._kept = radii[layout.agent_of_segment[heeds]]
        self._sharpness: FloatArray | None = None
        candidates = WallCandidates(
            layout, self._segments, boundary_vertices, boundary_edges, radii + reach,
            boundary if search is None else search,
        )  # fmt: skip
        felt = reach[(weights > 0) & np.isfinite(reach)]
        skin = 0.5 * (float(felt.max()) if len(felt) else float(radii.max()))
        shares = knot_shares(layout, len(boundary_vertices))
        potential: Potential = ContactBarriers(radii, mu * weights, reach, shares)
        coupling = None
        if smooth is not None:
            kept = np.full(reach.size, np.nan) if sharpness is None else sharpness
            alpha = np.where(np.isnan(kept), smooth.alpha_0, kept)
            each = len(boundary_edges) + len(boundary_vertices)
            contacts = (layout.num_segments * each).astype(np.float64)
            further = weighing_reach(contacts, alpha)
            candidates = replace(candidates, reach=radii + reach + further, sharpness=alpha)
            near = candidates.find(knots, skin)
            gaps = measure(candidates.positions(knots), near.points).distance
            self._sharpness = smooth.sharpened(kept, near, gaps, radii)
            alpha = np.where(np.isnan(self._sharpness), smooth.alpha_0, self._sharpness)
            candidates = replace(candidates, sharpness=alpha)
            potential = SmoothMinimumBarriers(
                radii, mu * weights, reach, alpha, cutoff=smooth.cutoff
            )
            coupling = DenseCoupling(candidates.find(knots, skin), len(knots), dimension=2)
        super().__init__(
            ContactSet.fresh(candidates, knots, skin),
            ContactModel(potential, partial(own_blocks, self._segments, len(knots)), coupling),
        )

    @classmethod
    def build(cls, setup: TermSetup) -> Wall | None:
        """Where there is a map, and an agent that minds its walls."""
        formulation, problem = setup.formulation, setup.formulation.problem
        weights = formulation.weights("wall")
        # Where motion is prescribed, its walls are no concern of the planner.
        weights[problem.prescribed] = 0.0
        if problem.free_space is None or problem.boundary is None or not weights.any():
            return None
        return cls(
            setup.knots, formulation.layout, problem.boundary,
            problem.free_space.boundary_vertices, problem.free_space.boundary_edges,
            problem.radii * (1 + formulation.padding), weights * formulation.scales.barrier, setup.mu,
            formulation.scales.wall_reach,
            smooth=formulation.smooth_minimum, sharpness=setup.sharpness.get(cls.name),
        )  # fmt: skip

    @property
    def sharpness(self) -> FloatArray | None:
        """(A,) 1/m of every agent that came near a wall so far, nan elsewhere."""
        return self._sharpness

    def value(self, knots: FloatArray) -> float:
        """The cost, inf where something touches or crosses the boundary."""
        return np.inf if self._crosses(knots) else super().value(knots)

    def allows_step(self, start: FloatArray, end: FloatArray) -> bool:
        """Whether no segment passes through the boundary between the two."""
        ends = np.column_stack([self._segments, self._segments + 1])
        return walls_stay_clear(start[ends, :2], end[ends, :2], self._boundary, self._kept)

    def _crosses(self, knots: FloatArray) -> bool:
        starts = np.ascontiguousarray(knots[self._segments, :2])
        ends = np.ascontiguousarray(knots[self._segments + 1, :2])
        near = self._boundary.near(starts, ends, np.zeros(len(starts)))
        return bool(crossings(starts, ends, near, self._boundary.edges).any())
