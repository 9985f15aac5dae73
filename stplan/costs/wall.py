"""Wall cost: C^M_a = -mu K^M_a log(d_a - r_a), d_a in the plane   (the paper's map equation).

Distances of a curve to the boundary are taken knot to edge and corner to segment: together they are the
distance of the two polylines wherever the curve does not cross the boundary, and unlike segment against
segment they do not jump along parallel walls. Crossings are refused separately: the cost is inf there.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.costs.contacts.clearance_barriers import (
    Coefficients,
    contact_barriers,
    smooth_minimum_barriers,
)
from stplan.costs.contacts.contact_term import ContactList, ContactTerm, sharpened
from stplan.geometry.boundary_grid import BoundaryGrid, crossings
from stplan.geometry.contacts import measure
from stplan.problem.layout import KnotLayout


class Wall(ContactTerm):
    """Barriers between curves and the boundary of the free space.

    Args:
        knots: (M, 3) around which the structure is made; every curve must be clear there.
        layout: knots and agents.
        boundary_vertices: (B, 2) m.
        boundary_edges: (E, 2) indices.
        radii: (A,) r_a, m.
        weights: (A,) K^M; 0 switches an agent's walls off.
        mu: barrier weight.
        reach: (A,) clearance in m at which repulsion starts, inf for the unbounded logarithm.
        alpha_0: sharpness in 1/m of the smooth minimum, None for the model of contacts.
        exact: reserve what the exact Hessian of the smooth minimum needs.
        alphas: (A,) sharpness kept from an earlier run, nan where not chosen yet.
    """

    name = "wall"
    dimension = 2

    def __init__(
        self,
        knots: FloatArray,
        layout: KnotLayout,
        boundary_vertices: FloatArray,
        boundary_edges: IntArray,
        radii: FloatArray,
        weights: FloatArray,
        mu: float,
        reach: FloatArray,
        *,
        alpha_0: float | None = None,
        exact: bool = False,
        alphas: FloatArray | None = None,
        skin: float | None = None,
    ) -> None:
        self._vertices = np.column_stack([boundary_vertices, np.zeros(len(boundary_vertices))])
        self._edges = boundary_edges
        self._grid = BoundaryGrid(
            np.hstack(
                [boundary_vertices[boundary_edges[:, 0]], boundary_vertices[boundary_edges[:, 1]]]
            )
        )
        self._layout = layout
        self._radii = radii
        self._weights = mu * weights
        self._reach = reach
        self._alpha_0 = alpha_0
        self._alphas = np.full(len(radii), np.nan) if alphas is None else alphas
        self._segments = layout.segment[weights[layout.agent_of_segment] > 0]
        felt = reach[(weights > 0) & np.isfinite(reach)]
        own_skin = 0.5 * (float(felt.max()) if len(felt) else float(radii.max()))
        chosen = own_skin if skin is None else skin
        super().__init__(
            num_knots=len(knots),
            axis_scale=np.array([1.0, 1.0, 0.0]),
            skin=chosen,
            structure_skin=chosen,
            exact_coupling=exact and alpha_0 is not None,
        )
        self.start(knots)

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + B, 3): knots and corners in the plane."""
        flat = np.zeros_like(knots)
        flat[:, :2] = knots[:, :2]
        return np.vstack([flat, self._vertices])

    def structure_blocks(self, wide: ContactList) -> IntArray:
        """Every segment's own blocks: walls couple nothing else, so this structure is never stale."""
        del wide
        first, second = self._segments, self._segments + 1
        own = np.union1d(first, second)
        return np.vstack([np.column_stack([own, own]), np.column_stack([second, first])])

    def find_contacts(self, knots: FloatArray, skin: float) -> ContactList:
        """Knots near edges and segments near corners."""
        starts = np.ascontiguousarray(knots[self._segments, :2])
        ends = np.ascontiguousarray(knots[self._segments + 1, :2])
        agents = self._layout.agent_of_knot[self._segments]
        reach = (self._radii + self._reach + skin)[agents]
        if not np.isfinite(reach).all():
            reach = np.full(len(agents), 1e12)
        segment, edge = self._grid.near(starts, ends, reach)
        self._near_segment, self._near_edge = segment, edge
        first = self._segments[segment]
        knot_edge = _unique_rows(np.concatenate([first, first + 1]), np.concatenate([edge, edge]))
        corner = _unique_rows(
            np.concatenate([first, first]), self._edges[np.concatenate([edge, edge]), _ends(edge)]
        )
        offset = len(knots)
        points = np.vstack(
            [
                np.column_stack([knot_edge[:, [0, 0]], offset + self._edges[knot_edge[:, 1]]]),
                np.column_stack([corner[:, 0], corner[:, 0] + 1, offset + corner[:, [1, 1]]]),
            ]
        )
        if not len(points):
            empty = np.empty(0, dtype=np.int64)
            return ContactList.grouped(points, empty)
        agent = self._layout.agent_of_knot[points[:, 0]]
        distance = measure(self.positions(knots), points).distance
        keep = distance < (self._radii + self._reach + skin)[agent]
        contacts = ContactList.grouped(points[keep], agent[keep])
        if self._alpha_0 is not None and len(contacts.points):
            contacts = sharpened(
                contacts, measure(self.positions(knots), contacts.points).distance, skin,
                self._radii[contacts.keys], self._alpha_0, self._alphas, (contacts.keys,),
            )  # fmt: skip
        return contacts

    @property
    def alphas(self) -> FloatArray:
        """(A,) sharpness of every agent met so far, nan elsewhere."""
        return self._alphas

    def feasible(self, knots: FloatArray) -> bool:
        """Whether no segment crosses the boundary."""
        starts = np.ascontiguousarray(knots[self._segments, :2])
        ends = np.ascontiguousarray(knots[self._segments + 1, :2])
        edges = self._grid.edges
        return not crossings(starts, ends, self._near_segment, self._near_edge, edges).any()

    def coefficients(self, distance: FloatArray, contacts: ContactList) -> Coefficients:
        """Barriers of contacts, or of every agent's smooth minimum."""
        radius = self._radii[contacts.keys]
        weight = self._weights[contacts.keys]
        reach = self._reach[contacts.keys]
        if self._alpha_0 is None:
            members = contacts.members
            return contact_barriers(distance, radius[members], weight[members], reach[members])
        return smooth_minimum_barriers(
            distance, contacts.starts, self._alphas[contacts.keys], radius, weight, reach
        )


def _ends(edge: IntArray) -> IntArray:
    """Column 0 for the first half, 1 for the second: both corners of every edge."""
    return np.repeat(np.array([0, 1]), len(edge))


def _unique_rows(left: IntArray, right: IntArray) -> IntArray:
    """Distinct (left, right) pairs, sorted, (N, 2)."""
    if not len(left):
        return np.empty((0, 2), dtype=np.int64)
    width = int(right.max()) + 1
    codes = np.unique(left * width + right)
    return np.column_stack([codes // width, codes % width])
