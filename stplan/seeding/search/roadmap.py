"""The roadmap: a plane graph that knows the agents' radii.

Its vertices are the exact starts, goals and waypoints; rings just over a radius off the walls, with
mitred corners (round ones would be cut by the edges between them); centred medial points, so that
every passage wider than an agent is connected; and a hexagonal fill. Its edges are Delaunay's, with
their true distance to the walls, so that one graph serves every radius.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy.spatial import Voronoi, cKDTree

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.wall_distances import least_wall_distances
from stplan.seeding.search.graph import Graph, make_graph
from stplan.world.erosion import eroded
from stplan.world.sampling import (
    along,
    box_around,
    delaunay_edges,
    hexagonal_points,
    inside,
    points_of_rings,
    rings_of,
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
# Bisections that centre a medial point between its walls.
CENTRING_STEPS = 14
SAMPLES_PER_SPACING = 4.0
# Samples are moved by this part of their spacing, so that none lie on common circles.
SHAKE = 1e-6
# Rounds in which ways through tight bends get a point more.
BENDS = 2
MAX_SAMPLES = 20000
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
    ignores_walls: bool = False,
    refine: float = 1.0,
    around: float = 0.0,
) -> Roadmap:
    """A roadmap through `exact` points (P, 2) for agents that keep `radii` (n,), m, off the walls.

    `ignores_walls` keeps edges through walls, for agents that do not heed them; `refine` divides
    the spacing; `around` (m) is the room left around the points in the open plane.
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
    spacing = max(1.02 * least, float(np.sqrt(area / (0.866 * MAX_VERTICES)))) / refine
    medial = None if free_space is None else _medial_points(free_space, least, spacing)
    vertices = _vertices(region, places, distinct, spacing, medial)
    while len(vertices) > 2 * MAX_VERTICES * refine and spacing < 16 * least:
        spacing *= 1.5
        vertices = _vertices(region, places, distinct, spacing, medial)
    floor = -np.inf if ignores_walls else least
    vertices, edges = _triangulate(free_space, vertices, len(places), spacing, floor)
    clearance = np.concatenate(
        [
            _point_clearance(free_space, vertices),
            _edge_clearance(free_space, vertices, edges),
        ]
    )
    kept = clearance[len(vertices) :] > floor
    clearance = np.concatenate([clearance[: len(vertices)], clearance[len(vertices) :][kept]])
    return Roadmap(make_graph(vertices, edges[kept], clearance), place_of)


def mesh_roadmap(mesh: SeedingMesh, exact: FloatArray) -> Roadmap:
    """A seeding mesh as it is; `exact` points (P, 2) are among its vertices."""
    clearance = np.concatenate([mesh.vertex_clearance, mesh.edge_clearance])
    graph = make_graph(mesh.vertices, mesh.edges, clearance)
    place_of = cKDTree(mesh.vertices).query(exact)[1]
    return Roadmap(graph, np.ravel(place_of).astype(np.int64))


def _vertices(
    region: shapely.Geometry,
    places: FloatArray,
    radii: FloatArray,
    spacing: float,
    medial: tuple[FloatArray, FloatArray] | None,
) -> FloatArray:
    """All points of the roadmap, the places first, thinned to about `spacing`.

    `medial`: medial points and their room, None in the open plane.
    """
    least = float(radii[0])
    points = [places]
    apart = [np.zeros(len(places))]

    def offer(more: FloatArray, distance: float) -> None:
        points.append(more.reshape(-1, 2))
        apart.append(np.full(len(points[-1]), distance))

    if medial is not None:
        step = max(1, -(-len(radii) // MAX_RINGS))
        for radius in radii[::step]:
            rings = rings_off_the_walls(region, float(radius))
            offer(points_of_rings(rings, spacing), 0.12 * min(spacing, least))
        middles, room = medial
        narrow, tight = room < 1.1 * least, room < 1.3 * least
        offer(middles[narrow], 0.12 * min(spacing, least))
        offer(middles[tight & ~narrow], 0.3 * spacing)
        offer(middles[~tight], 0.45 * spacing)
    for reach in _halvings(spacing, least):
        offer(_star_points(region, places, reach), 0.45 * reach)
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


def _medial_points(
    free_space: FreeSpace, radius: float, spacing: float
) -> tuple[FloatArray, FloatArray]:
    """Voronoi vertices of the walls with more room than `radius` (m), and the room of each.

    Those in tight places are centred, so that the edges between them are as free as can be.
    """
    perimeter = float(free_space.polygon.length)
    step = max(min(spacing, radius) / SAMPLES_PER_SPACING, perimeter / MAX_SAMPLES)
    samples = np.vstack([along(ring, step) for ring in rings_of(free_space.polygon)])
    samples = np.unique(samples, axis=0)
    # Of many points on common circles, as on a rectangle's sides, Qhull makes very large facets.
    samples += np.random.default_rng(0).uniform(-SHAKE * step, SHAKE * step, samples.shape)
    points = inside(free_space.polygon, Voronoi(samples).vertices)
    room = _point_clearance(free_space, points)
    wide = points[room >= 1.5 * radius]
    tight = points[(room > 0.9 * radius) & (room < 1.5 * radius)]
    tight = thinned(tight, np.full(len(tight), 0.08 * radius))
    points = np.vstack([_centred(free_space, tight, step), wide])
    room = _point_clearance(free_space, points)
    return points[room > radius], room[room > radius]


def _centred(free_space: FreeSpace, points: FloatArray, reach: float) -> FloatArray:
    """`points` moved by at most `reach` straight away from their nearest wall to the most room."""
    if len(points) == 0:
        return points
    segments = free_space.boundary_segments
    walls = shapely.linestrings(segments.reshape(-1, 2, 2))
    nearest = shapely.STRtree(walls).query_nearest(shapely.points(points), all_matches=False)[1]
    head, tail = segments[nearest, :2], segments[nearest, 2:]
    along = ((points - head) * (tail - head)).sum(axis=1) / ((tail - head) ** 2).sum(axis=1)
    away = points - (head + np.clip(along, 0.0, 1.0)[:, None] * (tail - head))
    away /= np.maximum(np.hypot(away[:, 0], away[:, 1]), 1e-12)[:, None]
    low, high = np.zeros(len(points)), np.full(len(points), reach)
    grid = BoundaryGrid.from_segments(segments)

    def room(part: FloatArray) -> FloatArray:
        moved = points + part[:, None] * away
        # Moved by no more than the reach, nothing gets further off a wall than this.
        return least_wall_distances(moved, moved, gap + 2.0 * reach, grid)

    gap = float(_point_clearance(free_space, points).max())
    for _ in range(CENTRING_STEPS):
        first, second = low + (high - low) / 3, high - (high - low) / 3
        rises = room(first) < room(second)
        low, high = np.where(rises, first, low), np.where(rises, high, second)
    centred: FloatArray = points + ((low + high) / 2)[:, None] * away
    return centred


def _triangulate(
    free_space: FreeSpace | None,
    vertices: FloatArray,
    num_places: int,
    spacing: float,
    radius: float,
) -> tuple[FloatArray, IntArray]:
    """Vertices and edges: Delaunay's, long free ones split, and each place tied to those around.

    The ties matter where a place lies against a wall and its Delaunay neighbours behind it.
    """
    edges = delaunay_edges(vertices)
    if free_space is not None and np.isfinite(radius):
        for _ in range(BENDS):
            grown = _bent(free_space, vertices, edges, radius)
            if len(grown) == len(vertices):
                break
            vertices = grown
            edges = delaunay_edges(vertices)
    for _ in range(4):
        step = vertices[edges[:, 1]] - vertices[edges[:, 0]]
        long = edges[np.hypot(step[:, 0], step[:, 1]) > LONG_EDGE * spacing]
        long = long[_edge_clearance(free_space, vertices, long) > radius]
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
    free_space: FreeSpace, vertices: FloatArray, edges: IntArray, radius: float
) -> FloatArray:
    """`vertices`, and centred middles of edges of tight places that just miss the `radius` (m)."""
    tight = _point_clearance(free_space, vertices) < 1.3 * radius
    edges = edges[tight[edges].any(axis=1)]
    room = _edge_clearance(free_space, vertices, edges)
    ends = vertices[edges[(room > 0.8 * radius) & (room <= radius)]]
    middles = _centred(free_space, ends.mean(axis=1), 0.3 * radius)
    middles = middles[_point_clearance(free_space, middles) > radius]
    apart = np.concatenate([np.zeros(len(vertices)), np.full(len(middles), 0.1 * radius)])
    return thinned(np.vstack([vertices, middles]), apart)


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
