"""A triangle mesh of the free space with the agents' exact points among its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from stplan.arrays import FloatArray, IntArray
from stplan.scene.model import Agent, Scene
from stplan.world.free_space import FreeSpace
from stplan.world.sampling import (
    box_around,
    delaunay_edges,
    hexagonal_points,
    points_of_rings,
    rings_off_the_walls,
    thinned,
    ties,
    unique_edges,
)

MOST_VERTICES = 20_000
# The boundary is followed at no more distances than this in a crowd of mixed radii.
MOST_RINGS = 5
# Share of the wanted edge length that points of the fill keep from each other.
APART = 0.45
# Edges longer than this many wanted lengths are left out: they fan out along walls.
LONGEST = 4.0
# Nearest vertices to which an exact point is tied that the triangulation leaves alone.
TIES = 12


@dataclass(frozen=True)
class SeedingMesh:
    """A mesh that seeds can be searched on; every edge lies inside the free space.

    Attributes:
        vertices: (V, 2) in m.
        edges: (E, 2) vertex indices, rising within and between rows, each pair once.
        lengths: (E,) in m.
        vertex_clearance: (V,) distance to the walls in m, negative outside, inf in the open plane.
        edge_clearance: (E,) the same of whole edges.
    """

    vertices: FloatArray
    edges: IntArray
    lengths: FloatArray
    vertex_clearance: FloatArray
    edge_clearance: FloatArray


def build_seeding_mesh(
    scene: Scene, free_space: FreeSpace | None, stops: FloatArray | None = None
) -> SeedingMesh:
    """The seeding mesh of `scene`, of at most about MOST_VERTICES vertices.

    The exact points are `stops` (P, 2), by default the starts, waypoints and goals of the scene. Edges are as
    long as `map.resolution`, by default the smallest radius, and longer where that would take too many
    vertices.
    """
    if stops is None:
        stops = np.array([point for agent in scene.agents for point in _stops(agent)])
    exact = stops + 0.0
    places = np.unique(exact, axis=0)
    radii = np.unique([agent.radius for agent in scene.agents])
    region = box_around(places, 4.0 * float(radii[-1]))
    if free_space is not None:
        region = free_space.polygon
    spacing = _spacing(scene, region, float(radii[0]))
    own = _own_triangles(free_space)
    room = max(MOST_VERTICES, 2 * len(places))
    vertices = _points(free_space, region, places, radii, own, spacing)
    while len(vertices) > room:
        spacing *= 1.25
        vertices = _points(free_space, region, places, radii, own, spacing)
    edges = delaunay_edges(vertices)
    length = np.hypot(*(vertices[edges[:, 1]] - vertices[edges[:, 0]]).T)
    longest = LONGEST * max(spacing, 2 * float(radii[0]), region.length / (MOST_VERTICES / 4))
    edges = _kept(free_space, vertices, edges[length <= longest])
    # A place close to a wall may have all its neighbours behind it, and one very close to another
    # vertex is left out of the triangulation.
    degree = np.bincount(edges.ravel(), minlength=len(vertices))[: len(places)]
    tied = unique_edges(ties(np.flatnonzero(degree == 0), vertices, TIES))
    edges = unique_edges(np.vstack([edges, _kept(free_space, vertices, tied)]))
    step = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    if free_space is None:
        vertex_clearance = np.full(len(vertices), np.inf)
        edge_clearance = np.full(len(edges), np.inf)
    else:
        vertex_clearance = free_space.clearance(vertices)
        edge_clearance = free_space.segment_clearance(vertices[edges[:, 0]], vertices[edges[:, 1]])
    return SeedingMesh(
        vertices=vertices,
        edges=edges,
        lengths=np.hypot(step[:, 0], step[:, 1]),
        vertex_clearance=vertex_clearance,
        edge_clearance=edge_clearance,
    )


def _stops(agent: Agent) -> list[tuple[float, float]]:
    return [agent.start, *agent.waypoints, agent.goal]


def _spacing(scene: Scene, region: shapely.Geometry, radius: float) -> float:
    """The wanted edge length, as far as the number of vertices allows (m)."""
    wanted = None if scene.map is None else scene.map.resolution
    least = float(np.sqrt(region.area / (np.sqrt(0.75) * 0.7 * MOST_VERTICES)))
    return max(radius if wanted is None else wanted, least)


def _own_triangles(free_space: FreeSpace | None) -> FloatArray | None:
    """(F, 3, 2) the map's own triangles, None where it has none or far too many."""
    own = None if free_space is None else free_space.triangles
    return None if own is None or len(own) > MOST_VERTICES else own


def _points(
    free_space: FreeSpace | None,
    region: shapely.Geometry,
    places: FloatArray,
    radii: FloatArray,
    own: FloatArray | None,
    spacing: float,
) -> FloatArray:
    """All vertices, the places first: each keeps its distance from those before it."""
    offers = [(places, 0.0)]
    if free_space is not None:
        for radius in radii[:: -(-len(radii) // MOST_RINGS)].tolist():
            rings = rings_off_the_walls(region, radius)
            length = sum(float(np.hypot(*np.diff(ring, axis=0).T).sum()) for ring in rings)
            step = max(min(spacing, 2 * radius), length / (MOST_VERTICES / 4))
            offers.append((points_of_rings(rings, step), 0.25 * min(radius, spacing)))
    if own is not None:
        offers.append((np.unique(own.reshape(-1, 2), axis=0), APART * spacing))
        offers.append((_bisected(own, spacing), APART * spacing))
    else:
        offers.append((hexagonal_points(region, spacing), APART * spacing))
    if free_space is not None:
        offers[1:] = [(points[free_space.clearance(points) > 0], d) for points, d in offers[1:]]
    points = np.vstack([points for points, _ in offers])
    return thinned(points, np.concatenate([np.full(len(points), d) for points, d in offers]))


def _bisected(triangles: FloatArray, spacing: float) -> FloatArray:
    """Points that split `triangles` (F, 3, 2), longest side first, until no side exceeds `spacing`."""
    pieces = [np.empty((0, 2))]
    while len(triangles):
        sides = np.hypot(*np.moveaxis(np.roll(triangles, -1, axis=1) - triangles, 2, 0))
        long = sides.max(axis=1) > spacing
        triangles, longest = triangles[long], sides[long].argmax(axis=1)
        row = np.arange(len(triangles))
        head, tail, top = (triangles[row, (longest + k) % 3] for k in range(3))
        middle = (head + tail) / 2
        pieces.append(np.unique(middle, axis=0))
        triangles = np.concatenate(
            [np.stack([head, middle, top], axis=1), np.stack([middle, tail, top], axis=1)]
        )
        if sum(map(len, pieces)) > 20 * MOST_VERTICES:
            break
    return np.vstack(pieces)


def _kept(free_space: FreeSpace | None, vertices: FloatArray, edges: IntArray) -> IntArray:
    """The edges that stay inside the free space."""
    if free_space is None:
        return edges
    room = free_space.segment_clearance(vertices[edges[:, 0]], vertices[edges[:, 1]])
    return edges[room > 0]
