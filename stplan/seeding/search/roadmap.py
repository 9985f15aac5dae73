"""The roadmap: a plane graph that knows the agents' radii.

Its vertices are the exact starts, goals and waypoints; agents' own shortest ways, so that it misses none of
them; centred medial points, so that every passage wider than an agent is connected; rings just over a radius
off the walls, with mitred corners (round ones would be cut by the edges between them); and a hexagonal fill.
Its edges are Delaunay's and those along the ways, with their true distance to the walls, so that one graph
serves every radius.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy.spatial import cKDTree

from stplan.arrays import FloatArray, IntArray
from stplan.deadline import heed
from stplan.seeding.search.graph import Graph, make_graph
from stplan.seeding.search.medial_points import centred, medial_points, next_radius, slack
from stplan.seeding.search.way_edges import Track, way_edges
from stplan.world.erosion import eroded
from stplan.world.sampling import (
    box_around,
    delaunay_edges,
    hexagonal_points,
    inside,
    points_of_rings,
    rings_off_the_walls,
    thinned,
    ties,
    unique_edges,
)

if TYPE_CHECKING:
    from stplan.world import FreeSpace, SeedingMesh

# A graph with more vertices than this costs more in reservations than its resolution gains.
MAX_VERTICES = 7000
# More rings than this (of the radii of a mixed crowd) add vertices but hardly any passages.
MAX_RINGS = 5
# Edges longer than this many spacings are split: a hop takes one layer whatever its length.
LONG_EDGE = 2.0
# Rounds in which ways through tight bends get a point more, unless the spacing is so many times as wide as
# radii ask for: there the agents' own ways have to do.
BENDS = 2
COARSE = 2.0
# Passages less than so many times as wide as an agent are narrow, or tight.
NARROW, TIGHT = 1.1, 1.3
# Nearest vertices to which an exact point is tied, besides those of the triangulation.
TIES = 11


@dataclass(frozen=True)
class Roadmap:
    """A graph and where the exact points are in it.

    Attributes:
        graph: vertices, edges, clearances.
        place_of: (P,) vertex of every exact point it was built with.
    """

    graph: Graph
    place_of: IntArray


def build_roadmap(
    free_space: FreeSpace | None,
    exact: FloatArray,
    radii: FloatArray,
    *,
    tracks: Sequence[Track] = (),
    ignores_walls: bool = False,
    refine: float = 1.0,
    around: float = 0.0,
) -> Roadmap:
    """A roadmap through `exact` points (P, 2) for agents that keep `radii` (n,), m, off the walls.

    `tracks` between exact points are among its edges; `ignores_walls` keeps edges through walls, for agents
    that do not heed them; `refine` divides the spacing; `around` (m) is the room left around the points in
    the open plane.
    """
    distinct: FloatArray = np.unique(np.round(radii, 9)).astype(np.float64)
    places, place_of = np.unique(np.round(exact, 9), axis=0, return_inverse=True)
    place_of = np.ravel(place_of).astype(np.int64)
    # The exact coordinates, not the rounded ones: starts and goals are met to the last bit.
    places[place_of] = exact
    least = float(distinct[0])
    region = box_around(places, around) if free_space is None else free_space.polygon
    area = max(float(region.area), least * least)
    # A little over the radius: on a lattice of just the radius, two spacings tie with two radii.
    wanted = 1.02 * least / refine
    spacing = max(wanted, float(np.sqrt(area / (0.866 * MAX_VERTICES))) / refine)
    medial = None if free_space is None else medial_points(free_space, distinct, spacing)
    while True:
        heed()
        fixed, along = places, np.empty((0, 2), dtype=np.int64)
        if free_space is not None:
            fixed, along = way_edges(free_space, places, tracks, spacing)
        sizes = _Sizes(distinct, spacing, wanted)
        vertices = _vertices(region, fixed, len(places), sizes, medial)
        if len(vertices) <= 2 * MAX_VERTICES * refine or spacing >= 16 * least:
            break
        spacing *= 1.5
    heed()
    vertices, edges = _triangulate(free_space, vertices, len(places), sizes, ignores_walls)
    edges = unique_edges(np.vstack([edges, along]))
    heed()
    clearance = np.concatenate(
        [
            _point_clearance(free_space, vertices),
            _edge_clearance(free_space, vertices, edges),
        ]
    )
    kept = clearance[len(vertices) :] > (-np.inf if ignores_walls else sizes.floor)
    clearance = np.concatenate([clearance[: len(vertices)], clearance[len(vertices) :][kept]])
    return Roadmap(make_graph(vertices, edges[kept], clearance), place_of)


@dataclass(frozen=True)
class _Sizes:
    """Lengths that a roadmap is made of, in m.

    Attributes:
        radii: (K,) that it serves, rising.
        spacing: of the fill.
        wanted: the spacing that its radii ask for, less where there would be too many vertices.
    """

    radii: FloatArray
    spacing: float
    wanted: float

    @property
    def least(self) -> float:
        """The least radius."""
        return float(self.radii[0])

    @property
    def floor(self) -> float:
        """Edges nearer to the walls than this serve nobody: radii were rounded."""
        return self.least * (1.0 - 1e-9) - 1e-9

    @property
    def apart(self) -> float:
        """How near points of rings and of narrow passages may be: further in coarse roadmaps."""
        return 0.12 * min(self.spacing, self.least) + 0.3 * max(self.spacing - self.wanted, 0.0)


def mesh_roadmap(
    mesh: SeedingMesh, free_space: FreeSpace | None, exact: FloatArray, tracks: Sequence[Track] = ()
) -> Roadmap:
    """A seeding mesh as it is, and `tracks` between `exact` points (P, 2), which are among its vertices."""
    place_of = np.ravel(cKDTree(mesh.vertices).query(exact)[1]).astype(np.int64)
    clearance = np.concatenate([mesh.vertex_clearance, mesh.edge_clearance])
    if free_space is None or not tracks:
        return Roadmap(make_graph(mesh.vertices, mesh.edges, clearance), place_of)
    distinct, place = np.unique(exact, axis=0, return_inverse=True)
    own = np.empty(len(distinct), dtype=np.int64)
    own[np.ravel(place)] = place_of
    fixed, along = way_edges(free_space, distinct, tracks, float(np.median(mesh.lengths)))
    number = np.concatenate([own, len(mesh.vertices) + np.arange(len(fixed) - len(distinct))])
    vertices = np.vstack([mesh.vertices, fixed[len(distinct) :]])
    tied = ties(number[len(distinct) :], vertices, TIES)
    edges = unique_edges(np.vstack([mesh.edges, number[along], tied]))
    room = _edge_clearance(free_space, vertices, edges)
    clearance = np.concatenate([_point_clearance(free_space, vertices), room[room > 0]])
    return Roadmap(make_graph(vertices, edges[room > 0], clearance), place_of)


def _vertices(
    region: shapely.Geometry,
    fixed: FloatArray,
    num_places: int,
    sizes: _Sizes,
    medial: tuple[FloatArray, FloatArray] | None,
) -> FloatArray:
    """All points of the roadmap, the `fixed` ones first, thinned to about the spacing.

    `medial`: medial points and their room, None in the open plane.
    """
    spacing, least, radii = sizes.spacing, sizes.least, sizes.radii
    points = [fixed]
    apart = [np.zeros(len(fixed))]

    def offer(more: FloatArray, distance: float) -> None:
        points.append(more.reshape(-1, 2))
        apart.append(np.full(len(points[-1]), distance))

    if medial is not None:
        middles, room = medial
        share = slack(room, radii)
        narrow, tight = share < NARROW, share < TIGHT
        offer(middles[narrow], 0.12 * min(spacing, least))
        step = max(1, -(-len(radii) // MAX_RINGS))
        for radius in radii[::step]:
            heed()
            rings = rings_off_the_walls(region, float(radius))
            offer(points_of_rings(rings, spacing), sizes.apart)
        offer(middles[tight & ~narrow], 0.3 * spacing)
        offer(middles[~tight], 0.45 * spacing)
    for reach in _halvings(spacing, least):
        offer(_star_points(region, fixed[:num_places], reach), 0.45 * reach)
    heed()
    inner = region if medial is None else eroded(region, least, quad_segs=16)
    offer(hexagonal_points(inner, spacing), 0.45 * spacing)
    return thinned(np.vstack(points), np.concatenate(apart))


def _halvings(spacing: float, least: float) -> list[float]:
    """Distances from `least` doubled up to below `spacing`: a coarse fill grades down to places."""
    reaches = []
    reach = 1.5 * least
    while reach < 0.75 * spacing:
        reaches.append(reach)
        reach *= 2.0
    return reaches


def _star_points(region: shapely.Geometry, places: FloatArray, reach: float) -> FloatArray:
    """Eight points `reach` (m) around every place, where they are in the region."""
    angle = np.arange(8) * (np.pi / 4)
    star = reach * np.column_stack([np.cos(angle), np.sin(angle)])
    return inside(region, (places[:, None, :] + star[None]).reshape(-1, 2))


def _triangulate(
    free_space: FreeSpace | None,
    vertices: FloatArray,
    num_places: int,
    sizes: _Sizes,
    ignores_walls: bool,
) -> tuple[FloatArray, IntArray]:
    """Vertices and edges: Delaunay's, long free ones split, and each place tied to those around.

    The ties matter where a place lies against a wall and its Delaunay neighbours behind it.
    """
    spacing = sizes.spacing
    edges = delaunay_edges(vertices)
    if free_space is not None and not ignores_walls and spacing <= COARSE * sizes.wanted:
        for _ in range(BENDS):
            heed()
            grown = _bent(free_space, vertices, edges, sizes.radii)
            if len(grown) == len(vertices):
                break
            vertices = grown
            edges = delaunay_edges(vertices)
    least = -np.inf if ignores_walls else sizes.least
    for _ in range(4):
        heed()
        step = vertices[edges[:, 1]] - vertices[edges[:, 0]]
        long = edges[np.hypot(step[:, 0], step[:, 1]) > LONG_EDGE * spacing]
        long = long[_edge_clearance(free_space, vertices, long) > least]
        if len(long) == 0:
            break
        middles = (vertices[long[:, 0]] + vertices[long[:, 1]]) / 2
        apart = np.concatenate([np.zeros(len(vertices)), np.full(len(long), 0.45 * spacing)])
        grown = thinned(np.vstack([vertices, middles]), apart)
        if len(grown) == len(vertices):
            break
        vertices = grown
        edges = delaunay_edges(vertices)
    tied = ties(np.arange(num_places), vertices, TIES)
    step = vertices[tied[:, 0]] - vertices[tied[:, 1]]
    tied = tied[np.hypot(step[:, 0], step[:, 1]) < 3.0 * spacing]
    return vertices, unique_edges(np.vstack([edges, tied]))


def _bent(
    free_space: FreeSpace, vertices: FloatArray, edges: IntArray, radii: FloatArray
) -> FloatArray:
    """`vertices`, and centred middles of edges of tight places that just miss one of the `radii` (K,), m."""
    tight = slack(_point_clearance(free_space, vertices), radii) < TIGHT
    edges = edges[tight[edges].any(axis=1)]
    room = _edge_clearance(free_space, vertices, edges)
    radius = next_radius(np.nextafter(room, -np.inf), radii)
    missed = (room > 0.8 * radius) & (room <= radius)
    ends, radius = vertices[edges[missed]], radius[missed]
    middles = centred(free_space, ends.mean(axis=1), 0.3 * radius)
    free = _point_clearance(free_space, middles) > radius
    apart = np.concatenate([np.zeros(len(vertices)), 0.1 * radius[free]])
    return thinned(np.vstack([vertices, middles[free]]), apart)


def _point_clearance(free_space: FreeSpace | None, points: FloatArray) -> FloatArray:
    """(n,) distance of `points` (n, 2) to the walls, below 0 outside, inf in the open plane."""
    return np.full(len(points), np.inf) if free_space is None else free_space.clearance(points)


def _edge_clearance(
    free_space: FreeSpace | None, vertices: FloatArray, edges: IntArray
) -> FloatArray:
    """(E,) distance of edges to the walls, below 0 outside, inf in the open plane."""
    if free_space is None:
        return np.full(len(edges), np.inf)
    return free_space.segment_clearance(vertices[edges[:, 0]], vertices[edges[:, 1]])
