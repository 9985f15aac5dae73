"""Which knots and segments come near the boundary of the free space."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.contact_set import ContactList, ContactSet, distinct
from stplan.costs.contacts.rod_candidates import weighty
from stplan.geometry.contacts import measure
from stplan.problem.layout import KnotLayout


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
        reach = (self.reach + skin)[self.layout.agent_of_knot[self.segments]]
        if np.isfinite(reach).all():
            return self.search.near(starts, ends, reach)
        return AllEdges(len(self.edges)).near(starts, ends, reach)


def _unique_rows(left: IntArray, right: IntArray) -> IntArray:
    """Distinct (left, right) pairs, sorted, (N, 2)."""
    if not len(left):
        return np.empty((0, 2), dtype=np.int64)
    width = int(right.max()) + 1
    codes = distinct(left * width + right)
    return np.column_stack([codes // width, codes % width])
