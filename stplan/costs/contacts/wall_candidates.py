"""Which knots and segments come near the boundary of the free space."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.contact_set import ContactList, ContactSet, distinct
from stplan.costs.contacts.rod_candidates import weighty
from stplan.costs.contacts.smooth_minimum import NEGLIGIBLE
from stplan.geometry.contacts import measure
from stplan.geometry.wall_distances import least_wall_distance
from stplan.problem.layout import KnotLayout

# The nearest wall is looked for within this part of the map's extent first.
FIRST_LOOK = 256.0


class EdgeSearch(Protocol):
    """Finds boundary edges near segments."""

    def near(self, starts: FloatArray, ends: FloatArray, reach: FloatArray) -> IntArray:
        """Pairs (N, 2) of segment and edge, sorted, those nearer than `reach` (S,) m among them."""
        ...


@dataclass(frozen=True)
class AllEdges:
    """Every edge is near: for small scenes and for reaches without end."""

    num_edges: int

    def near(self, starts: FloatArray, ends: FloatArray, reach: FloatArray) -> IntArray:
        """All pairs."""
        del ends, reach
        segments, edges = np.arange(len(starts)), np.arange(self.num_edges)
        return np.column_stack([np.repeat(segments, len(edges)), np.tile(edges, len(segments))])


@dataclass(frozen=True)
class WallCandidates:
    """Knots near edges and segments near corners.

    Attributes:
        layout: knots and agents.
        segments: (S,) first knots of the segments that heed walls.
        vertices: (B, 2) corners of the boundary, m.
        edges: (E, 2) their indices.
        reach: (A,) m, the distance from which on an agent feels nothing; inf where there is none.
        search: finds near edges.
        sharpness: (A,) 1/m of smooth minima, None where every contact is felt on its own.
    """

    layout: KnotLayout
    segments: IntArray
    vertices: FloatArray
    edges: IntArray
    reach: FloatArray
    search: EdgeSearch
    sharpness: FloatArray | None = None

    @cached_property
    def axis_scale(self) -> FloatArray:
        """(1, 1, 0): walls are upright."""
        return np.array([1.0, 1.0, 0.0])

    @cached_property
    def _corners(self) -> FloatArray:
        return np.column_stack([self.vertices, np.zeros(len(self.vertices))])

    def positions(self, knots: FloatArray) -> FloatArray:
        """(M + B, 3): knots and corners in the plane."""
        flat = np.zeros_like(knots)
        flat[:, :2] = knots[:, :2]
        return np.vstack([flat, self._corners])

    def find(self, knots: FloatArray, skin: float) -> ContactList:
        """Knots near edges and segments near corners."""
        segment, edge = self._near(knots, skin).T
        first = self.segments[segment]
        knot_edge = _unique_rows(np.concatenate([first, first + 1]), np.concatenate([edge, edge]))
        ends = self.edges[np.concatenate([edge, edge]), np.repeat([0, 1], len(edge))]
        corner = _unique_rows(np.concatenate([first, first]), ends)
        offset = len(knots)
        points = np.vstack(
            [
                np.column_stack([knot_edge[:, [0, 0]], offset + self.edges[knot_edge[:, 1]]]),
                np.column_stack([corner[:, 0], corner[:, 0] + 1, offset + corner[:, [1, 1]]]),
            ]
        )
        agent = self.layout.agent_of_knot[points[:, 0]]
        positions = self.positions(knots)
        keep = measure(positions, points).distance < (self.reach + skin)[agent]
        contacts = ContactList.grouped(points[keep], agent[keep])
        if self.sharpness is not None:
            contacts = weighty(contacts, positions, self.sharpness, skin)
        return contacts

    def renew(self, old: ContactSet, knots: FloatArray, moved: BoolArray) -> ContactSet:
        """The whole list anew: it is short."""
        del moved
        return ContactSet.fresh(self, knots, old.skin)

    def _near(self, knots: FloatArray, skin: float) -> IntArray:
        starts = np.ascontiguousarray(knots[self.segments, :2])
        ends = np.ascontiguousarray(knots[self.segments + 1, :2])
        agents = self.layout.agent_of_knot[self.segments]
        reach = self.reach
        if not np.isfinite(reach).all() and self.sharpness is not None:
            reach = self._weighing_reach(starts, ends, agents, self.sharpness) + 2 * skin
        reach = (reach + skin)[agents]
        if np.isfinite(reach).all():
            return self.search.near(starts, ends, reach)
        return AllEdges(len(self.edges)).near(starts, ends, reach)

    def _weighing_reach(
        self, starts: FloatArray, ends: FloatArray, agents: IntArray, sharpness: FloatArray
    ) -> FloatArray:
        """(A,) m, how far edges may be that weigh in the smooth minimum of an agent without a reach."""
        walls = self.vertices[self.edges].reshape(-1, 4)
        first_look = float(np.linalg.norm(np.ptp(self.vertices, axis=0))) / FIRST_LOOK
        result = self.reach.copy()
        for agent in np.unique(agents[np.isinf(self.reach[agents])]).tolist():
            own = agents == agent
            heads, tails = starts[own], ends[own]
            reach, least = first_look, np.inf
            while least >= reach:
                reach *= 2.0
                near = self.search.near(heads, tails, np.full(len(heads), reach))
                least = least_wall_distance(heads, tails, near, walls)
            result[agent] = least + NEGLIGIBLE / sharpness[agent]
        return result


def _unique_rows(left: IntArray, right: IntArray) -> IntArray:
    """Distinct (left, right) pairs, sorted, (N, 2)."""
    if not len(left):
        return np.empty((0, 2), dtype=np.int64)
    width = int(right.max()) + 1
    codes = distinct(left * width + right)
    return np.column_stack([codes // width, codes % width])
