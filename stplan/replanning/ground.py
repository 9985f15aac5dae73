"""How far it is from everywhere to a point, around walls: quick enough to be asked anew every half second.

Spots of a lattice, and some around every corner, are joined where the straight way between them is clear. A
way to a point leads straight there from wherever that is seen, elsewhere from spot to spot.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.visibility import clear_segments
from stplan.problem.shortest_ways import corners
from stplan.world.free_space import FreeSpace

# About so many spots, no further apart than so many radii.
NUM_SPOTS = 1500
WIDEST = 2.0
# Spots are joined that are at most so many steps of the lattice apart.
JOINED = 2.3
# Spots around a corner, and how far beyond the radius, as a share of it.
CORNER_SPOTS = 3
CORNER_ROOM = 0.05
# A way from a point begins at one of so many near spots.
NEAR = 12
# What walls are kept beyond the radius, as a share of it.
ROOM = 1e-6


@dataclass(frozen=True)
class Ground:
    """Where an agent of some radius can be.

    Attributes:
        gap: what its centre keeps from the walls, m.
        spots: (N, 2) m.
        walls: the boundary.
        step: of the lattice, m.
    """

    gap: float
    spots: FloatArray
    walls: BoundaryGrid
    step: float

    @staticmethod
    def of(space: FreeSpace, radius: float) -> Ground:
        """The ground of agents of a `radius` in a free space."""
        gap = (1.0 + ROOM) * radius
        walls = BoundaryGrid.from_segments(space.boundary_segments)
        low, high = space.boundary_vertices.min(axis=0), space.boundary_vertices.max(axis=0)
        area = float(space.polygon.area)
        step = min(float(np.sqrt(area / NUM_SPOTS)), WIDEST * radius)
        axes = [np.arange(low[x] + 0.5 * step, high[x], step) for x in range(2)]
        lattice = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        bends = corners(space)
        share = np.linspace(0.0, 1.0, CORNER_SPOTS)
        angles = bends[:, 2, None] + bends[:, 3, None] * share[None, :]
        normals = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        around = (bends[:, None, :2] + (1.0 + CORNER_ROOM) * radius * normals).reshape(-1, 2)
        spots = np.vstack([lattice, around])
        spots = spots[space.contains(spots)]
        spots = np.ascontiguousarray(spots[clear_segments(spots, spots, gap, walls)])
        return Ground(gap, spots, walls, step)

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree(self.spots)

    @cached_property
    def _graph(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Row pointers, columns and lengths of the joined spots, both ways, m."""
        pairs = self._tree.query_pairs(JOINED * self.step, output_type="ndarray")
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        pairs = pairs[self.sees(self.spots[pairs[:, 0]], self.spots[pairs[:, 1]])]
        lengths = np.hypot(*(self.spots[pairs[:, 0]] - self.spots[pairs[:, 1]]).T)
        both = np.vstack([pairs, pairs[:, ::-1]])
        count = len(self.spots)
        graph = csr_array((np.tile(lengths, 2), (both[:, 0], both[:, 1])), shape=(count, count))
        return graph.indptr.astype(np.int64), graph.indices.astype(np.int64), graph.data

    def sees(self, heads: FloatArray, tails: FloatArray) -> BoolArray:
        """(n,) whether straight ways (n, 2) are clear of the walls."""
        return clear_segments(
            np.ascontiguousarray(heads), np.ascontiguousarray(tails), self.gap, self.walls
        )

    def near(self, points: FloatArray) -> IntArray:
        """(n, k) spots near points (n, 2)."""
        found = self._tree.query(points, k=min(NEAR, len(self.spots)))[1]
        return np.asarray(found, dtype=np.int64).reshape(len(points), -1)

    def distances_to(self, target: FloatArray, usable: BoolArray | None = None) -> Distances:
        """Lengths of ways from everywhere to a point (2,), over `usable` spots (N,) alone where given."""
        count = len(self.spots)
        pointers, columns, lengths = self._graph
        if usable is None:
            near = np.arange(count)
        else:
            lengths = np.where(usable[columns], lengths, np.inf)
            near = np.flatnonzero(usable & self.close(target, self.spots))
        heads = np.broadcast_to(target, (len(near), 2))
        seen = near[self.sees(heads, self.spots[near])]
        straight = np.hypot(*(self.spots[seen] - target).T)
        graph = csr_array(
            (
                np.concatenate([lengths, straight]),
                np.concatenate([columns, seen]),
                np.append(pointers, pointers[-1] + len(seen)),
            ),
            shape=(count + 1, count + 1),
        )
        found, before = dijkstra(graph, indices=[count], return_predecessors=True)
        nexts = before[0, :count].astype(np.int64)
        return Distances(self, np.array(target), found[0, :count], nexts, usable is not None)

    def close(self, target: FloatArray, points: FloatArray) -> BoolArray:
        """(n,) which points are as near to a target (2,) as spots that are joined."""
        return np.asarray(np.hypot(*(points - target).T) <= JOINED * self.step)


@dataclass(frozen=True)
class Distances:
    """Lengths of ways to a `target` (2,).

    Attributes:
        of_spots: (N,) m, inf where there is no way.
        nexts: (N,) the spot after each on its way, no less than N where that is the target.
        over_spots: whether ways lead from spot to spot even where the target is seen from afar.
    """

    ground: Ground
    target: FloatArray
    of_spots: FloatArray
    nexts: IntArray
    over_spots: bool = False

    def at(self, points: FloatArray) -> FloatArray:
        """(n,) of points (n, 2), m; twice the straight distance from where no spot is seen."""
        return self._ways(points)[0]

    def next_from(self, point: FloatArray) -> FloatArray:
        """(2,) where the way from a point leads first."""
        spot = int(self._ways(point[None])[1][0])
        return self.target if spot < 0 else self.ground.spots[spot]

    def way_from(self, spot: int) -> FloatArray:
        """(n, 2) the way from a spot to the target, with no more corners than walls ask for."""
        knots = []
        while 0 <= spot < len(self.nexts):
            knots.append(self.ground.spots[spot])
            spot = int(self.nexts[spot])
        way = np.array([*knots, self.target])
        pulled = [0]
        while pulled[-1] < len(way) - 1:
            rest = way[pulled[-1] + 1 :]
            seen = self.ground.sees(np.broadcast_to(way[pulled[-1]], rest.shape), rest)
            hidden = np.flatnonzero(~seen)
            pulled.append(pulled[-1] + max(int(hidden[0]) if len(hidden) else len(rest), 1))
        return np.asarray(way[pulled])

    def _ways(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """(n,) lengths, and the spots the ways begin at, negative where straight at the target."""
        straight = np.hypot(*(points - self.target).T)
        begins = np.full(len(points), -1)
        heads = np.broadcast_to(self.target, points.shape)
        seen = self.ground.sees(heads, points)
        if self.over_spots:
            seen = seen & self.ground.close(self.target, points)
        hidden = np.flatnonzero(~seen)
        lengths = straight.copy()
        if not len(hidden):
            return lengths, begins
        spots = self.ground.near(points[hidden])
        heads = np.repeat(points[hidden], spots.shape[1], axis=0)
        tails = self.ground.spots[spots.ravel()]
        legs = np.hypot(*(heads - tails).T)
        ways = np.where(self.ground.sees(heads, tails), legs + self.of_spots[spots.ravel()], np.inf)
        ways = ways.reshape(spots.shape)
        best = ways.argmin(axis=1)
        rows = np.arange(len(hidden))
        known = np.isfinite(ways[rows, best])
        lengths[hidden] = np.where(known, ways[rows, best], 2.0 * straight[hidden])
        begins[hidden] = np.where(known, spots[rows, best], -1)
        return lengths, begins
