"""A triangle mesh of the free space with the agents' exact points among its vertices."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from scipy.spatial import Delaunay, QhullError, cKDTree

from stplan.arrays import FloatArray, IntArray
from stplan.scene.model import Agent, Scene
from stplan.world.erosion import eroded
from stplan.world.free_space import FreeSpace

MOST_VERTICES = 20_000
# Points follow the boundary this much further off than a radius, so that chords between them are free.
RING_OFFSET = 1.02
RING_TOLERANCE = 0.012
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
        triangles: (F, 3) vertex indices; their sides are edges and they lie in the free space.
        terminals: (P,) vertex of every exact point: for each agent start, waypoints, goal.
        vertex_clearance: (V,) distance to the walls in m, negative outside, inf in the open plane.
        edge_clearance: (E,) the same of whole edges.
    """

    vertices: FloatArray
    edges: IntArray
    lengths: FloatArray
    triangles: IntArray
    terminals: IntArray
    vertex_clearance: FloatArray
    edge_clearance: FloatArray


def build_seeding_mesh(scene: Scene, free_space: FreeSpace | None) -> SeedingMesh:
    """The seeding mesh of `scene`, of at most about MOST_VERTICES vertices.

    Edges are as long as `map.resolution`, by default the smallest radius, and longer where that
    would take too many vertices.
    """
    exact = np.array([point for agent in scene.agents for point in _stops(agent)]) + 0.0
    places, terminals = np.unique(exact, axis=0, return_inverse=True)
    radii = np.unique([agent.radius for agent in scene.agents])
    region = _open_region(places, float(radii[-1])) if free_space is None else free_space.polygon
    spacing = _spacing(scene, region, float(radii[0]))
    own = _own_triangles(free_space)
    room = max(MOST_VERTICES, 2 * len(places))
    vertices = _points(free_space, region, places, radii, own, spacing)
    while len(vertices) > room:
        spacing *= 1.25
        vertices = _points(free_space, region, places, radii, own, spacing)
    triangles = _delaunay(vertices)
    edges = _sides(vertices, triangles)
    length = np.hypot(*(vertices[edges[:, 1]] - vertices[edges[:, 0]]).T)
    longest = LONGEST * max(spacing, 2 * float(radii[0]), region.length / (MOST_VERTICES / 4))
    edges = _kept(free_space, vertices, edges[length <= longest])
    ties = _ties(vertices, edges, len(places))
    if len(ties):
        edges = _unique_edges(np.vstack([edges, _kept(free_space, vertices, ties)]))
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
        triangles=_inner_triangles(free_space, vertices, edges, triangles),
        terminals=np.ravel(terminals).astype(np.int64),
        vertex_clearance=vertex_clearance,
        edge_clearance=edge_clearance,
    )


def _stops(agent: Agent) -> list[tuple[float, float]]:
    return [agent.start, *agent.waypoints, agent.goal]


def _open_region(places: FloatArray, radius: float) -> shapely.Geometry:
    """A box around the places with room to evade."""
    low, high = places.min(axis=0), places.max(axis=0)
    room = 4 * radius + 0.1 * float((high - low).max())
    return shapely.box(low[0] - room, low[1] - room, high[0] + room, high[1] + room)


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
            rings = _ring_points(region, radius, spacing)
            offers.append((rings, 0.25 * min(radius, spacing)))
    if own is not None:
        offers.append((np.unique(own.reshape(-1, 2), axis=0), APART * spacing))
        offers.append((_bisected(own, spacing), APART * spacing))
    else:
        offers.append((_hexagonal_points(region, spacing), APART * spacing))
    if free_space is not None:
        offers[1:] = [(points[free_space.clearance(points) > 0], d) for points, d in offers[1:]]
    points = np.vstack([points for points, _ in offers])
    return _thinned(points, np.concatenate([np.full(len(points), d) for points, d in offers]))


def _hexagonal_points(region: shapely.Geometry, spacing: float) -> FloatArray:
    """A hexagonal lattice inside `region`."""
    left, bottom, right, top = region.bounds
    rise = spacing * np.sqrt(0.75)
    rows = np.arange(int((top - bottom) / rise) + 2)
    pieces = []
    columns = left + spacing * np.arange(int((right - left) / spacing) + 2)
    shapely.prepare(region)
    for row in rows.tolist():
        x = columns + 0.5 * spacing * (row % 2)
        y = np.full(len(x), bottom + row * rise)
        inside = shapely.contains_xy(region, x, y)
        pieces.append(np.column_stack([x[inside], y[inside]]))
    return np.vstack(pieces)


def _ring_points(region: shapely.Geometry, radius: float, spacing: float) -> FloatArray:
    """Points that follow the boundary just over `radius` off it (m)."""
    inner = eroded(region, radius * RING_OFFSET, join_style="mitre", mitre_limit=1.6)
    inner = shapely.simplify(inner, RING_TOLERANCE * radius)
    step = max(min(spacing, 2 * radius), float(inner.length) / (MOST_VERTICES / 4))
    pieces = [np.empty((0, 2))]
    for part in shapely.get_parts(inner):
        for ring in () if part.is_empty else (part.exterior, *part.interiors):
            for head, tail in pairwise(np.asarray(ring.coords)[:, :2]):
                count = max(int(np.ceil(np.hypot(*(tail - head)) / step)), 1)
                pieces.append(head + (tail - head) * (np.arange(count) / count)[:, None])
    return np.vstack(pieces)


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


def _thinned(points: FloatArray, apart: FloatArray) -> FloatArray:
    """`points` in order, each left out that has a kept one before it nearer than its `apart` (m)."""
    near = cKDTree(points).query_ball_point(points, apart, return_sorted=True)
    kept = np.ones(len(points), dtype=bool)
    for index in np.flatnonzero(apart > 0).tolist():
        for other in near[index]:
            if other >= index:
                break
            if kept[other]:
                kept[index] = False
                break
    return points[kept]


def _delaunay(points: FloatArray) -> IntArray:
    """(F, 3) Delaunay triangles, none where all points lie on a line."""
    if len(points) < 3:
        return np.empty((0, 3), dtype=np.int64)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    try:
        triangles = Delaunay((points - centre) / np.ptp(points, axis=0).max()).simplices
    except QhullError:
        return np.empty((0, 3), dtype=np.int64)
    triangles = np.sort(triangles, axis=1).astype(np.int64)
    return np.unique(triangles, axis=0)


def _sides(points: FloatArray, triangles: IntArray) -> IntArray:
    """Edges of triangles; without any, of neighbours along the line on which all points lie."""
    if not len(triangles):
        order = np.lexsort((points[:, 1], points[:, 0]))
        return _unique_edges(np.column_stack([order[:-1], order[1:]]))
    return _unique_edges(triangles[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2))


def _unique_edges(edges: IntArray) -> IntArray:
    return np.unique(np.sort(edges.astype(np.int64), axis=1), axis=0).reshape(-1, 2)


def _kept(free_space: FreeSpace | None, vertices: FloatArray, edges: IntArray) -> IntArray:
    """The edges that stay inside the free space."""
    if free_space is None:
        return edges
    room = free_space.segment_clearance(vertices[edges[:, 0]], vertices[edges[:, 1]])
    return edges[room > 0]


def _ties(vertices: FloatArray, edges: IntArray, num_places: int) -> IntArray:
    """Edges from places (the first vertices) that have none to the vertices nearest to them.

    A place close to a wall may have all its neighbours behind it, and one very close to another
    vertex is left out of the triangulation.
    """
    alone = np.flatnonzero(np.bincount(edges.ravel(), minlength=len(vertices))[:num_places] == 0)
    if not len(alone) or len(vertices) < 2:
        return np.empty((0, 2), dtype=np.int64)
    near = cKDTree(vertices).query(vertices[alone], k=min(TIES + 1, len(vertices)))[1]
    ties = np.column_stack([np.repeat(alone, near.shape[1]), near.ravel()])
    return _unique_edges(ties[ties[:, 0] != ties[:, 1]])


def _inner_triangles(
    free_space: FreeSpace | None, vertices: FloatArray, edges: IntArray, triangles: IntArray
) -> IntArray:
    """The triangles whose three sides are edges and that hold no hole."""
    code = edges[:, 0] * len(vertices) + edges[:, 1]
    sides = triangles[:, [0, 1, 2]] * 0
    for k, (i, j) in enumerate(((0, 1), (1, 2), (0, 2))):
        sides[:, k] = triangles[:, i] * len(vertices) + triangles[:, j]
    triangles = triangles[np.isin(sides, code).all(axis=1)]
    if free_space is None or not len(triangles):
        return triangles
    return triangles[shapely.covers(free_space.polygon, shapely.polygons(vertices[triangles]))]
