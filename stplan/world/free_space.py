"""The free space: where centres of agents may be, before their radius is taken off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.errors import SceneError
from stplan.maps.floor import pieces, polylines, read_floor
from stplan.maps.reader import MapError, Note
from stplan.scene.model import Scene
from stplan.schema.collector import collector_paused

# A wall without thickness is opened this wide in `FreeSpace.polygon`: a share of the map's extent, but
# many roundings of its coordinates.
HAIR, HAIR_ROUNDINGS = 1e-9, 64


@dataclass(frozen=True)
class FreeSpace:
    """The map as a polygon with its boundary.

    Walls without thickness (slits) are edges of the boundary that bound nothing: `clearance` is exactly
    that to them. An area cannot have such edges, so in `polygon` they are opened by a hair, some 1e-9 of
    the extent: whatever erodes it, asks what it covers or which of its parts hold a point sees them too.

    Attributes:
        polygon: shapely Polygon or MultiPolygon, m.
        boundary_vertices: (B, 2) corners of outer rings, holes and slits, m.
        boundary_edges: (E, 2) indices into them, those of slits last. Every corner is the first end of
            an edge: an open slit's last edge is two, that run from both of its ends to its middle.
        triangles: (F, 3, 2) triangles that the map was drawn with, m, None where it has none.
        slits: polylines (n, 2) among the edges, m.
        area: the polygon with its slits closed.
        notes: about the map, for its user.
    """

    polygon: shapely.Geometry
    boundary_vertices: FloatArray
    boundary_edges: IntArray
    triangles: FloatArray | None
    slits: tuple[FloatArray, ...]
    area: shapely.Geometry
    notes: tuple[Note, ...] = ()

    @staticmethod
    def from_polygon(
        polygon: shapely.Geometry,
        triangles: FloatArray | None = None,
        slits: Sequence[FloatArray] = (),
        straight: float = 0.0,
    ) -> FreeSpace:
        """The free space of a polygon; collinear corners are dropped, order is canonical.

        Corners are collinear that lie at most `straight` (m) off the line through their neighbours.
        """
        area = shapely.normalize(shapely.simplify(polygon, straight, preserve_topology=True))
        parts = shapely.get_parts(area)
        rings = shapely.get_rings(parts[shapely.area(parts) > 0])
        corners, owner = shapely.get_coordinates(rings, return_index=True)
        ends = np.hstack([corners[:-1], corners[1:]])[np.diff(owner) == 0]
        ends = np.vstack([ends, _slit_edges(slits)])
        vertices, place = _distinct(ends.reshape(-1, 2))
        edges = place.reshape(-1, 2)
        edges = np.ascontiguousarray(edges[edges[:, 0] != edges[:, 1]])
        opened = _opened(area, slits)
        shapely.prepare(opened)
        return FreeSpace(opened, vertices, edges, triangles, tuple(slits), area)

    def within(self, region: shapely.Geometry) -> FreeSpace:
        """The part of it inside `region`, a polygon."""
        slits = pieces(shapely.intersection(polylines(self.slits), region))
        return FreeSpace.from_polygon(shapely.intersection(self.area, region), None, slits)

    def moved(self, move: Callable[[FloatArray], FloatArray], straight: float = 0.0) -> FreeSpace:
        """The free space with all points (N, 2) where `move` takes them, without mirroring.

        Corners that come to lie at most `straight` (m) off the line through their neighbours are dropped.
        """
        area = shapely.transform(self.area, move)
        if not shapely.is_valid(area):
            # What touched itself may cross itself by a rounding now.
            area = shapely.buffer(area, 0.0)
        triangles = self.triangles
        if triangles is not None:
            triangles = move(triangles.reshape(-1, 2)).reshape(triangles.shape)
        slits = [move(slit) for slit in self.slits]
        return FreeSpace.from_polygon(area, triangles, slits, straight)

    @cached_property
    def boundary_segments(self) -> FloatArray:
        """(E, 4) edges as x0, y0, x1, y1, m."""
        corners = self.boundary_vertices[self.boundary_edges]
        return np.ascontiguousarray(corners.reshape(-1, 4))

    @cached_property
    def boundary(self) -> shapely.Geometry:
        """All edges as one prepared geometry."""
        lines = shapely.multilinestrings(
            shapely.linestrings(self.boundary_segments.reshape(-1, 2, 2))
        )
        shapely.prepare(lines)
        return lines

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(shapely.linestrings(self.boundary_segments.reshape(-1, 2, 2)))

    def contains(self, points: FloatArray) -> BoolArray:
        """Which points (P, 2) lie strictly inside."""
        return np.asarray(shapely.contains_xy(self.polygon, points[:, 0], points[:, 1]))

    def clearance(self, points: FloatArray) -> FloatArray:
        """(P,) distance of points to the boundary in m, negative outside."""
        distance = self._distance(shapely.points(points))
        return np.where(self.contains(points), distance, -distance)

    def segment_clearance(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        """(S,) distance of whole segments to the boundary in m, negative where outside or across."""
        lines = shapely.linestrings(np.stack([starts, ends], axis=1))
        distance = self._distance(lines)
        inside = self.contains((starts + ends) / 2)
        return np.where((distance > 0) & inside, distance, -np.maximum(distance, 1e-12))

    def _distance(self, shapes: FloatArray) -> FloatArray:
        if not len(shapes):
            return np.empty(0)
        (index, _), distance = self._tree.query_nearest(
            shapes, return_distance=True, all_matches=False
        )
        result = np.empty(len(shapes))
        result[index] = distance
        return result


def _distinct(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The distinct ones of points (P, 2), sorted by x and y, and which of them each is (P,)."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    new = np.ones(len(points), dtype=bool)
    new[1:] = (np.diff(points[order], axis=0) != 0).any(axis=1)
    place = np.empty(len(points), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return np.ascontiguousarray(points[order][new]), place


def build_free_space(scene: Scene) -> FreeSpace | None:
    """The free space of `scene`, None where it has no map (the plane is open).

    Raises:
        SceneError: the mesh cannot be read, or nothing is left of the map.
    """
    if scene.map is None:
        return None
    with collector_paused():
        try:
            floor = read_floor(scene.map, min(agent.radius for agent in scene.agents))
        except MapError as fault:
            raise SceneError(scene.located(fault.path, fault.text)) from fault
        free_space = FreeSpace.from_polygon(floor.area, floor.triangles, floor.slits)
    return replace(free_space, notes=floor.notes)


def warnings_of(scene: Scene, free_space: FreeSpace | None) -> list[str]:
    """What the user of `scene` has to know about its map, with file, line and key."""
    notes = () if free_space is None else free_space.notes
    return [f"warning: {scene.located(note.path, note.sentence)}" for note in notes]


def _slit_edges(slits: Sequence[FloatArray]) -> FloatArray:
    """(S, 4) edges of polylines (n, 2), as `FreeSpace.boundary_edges` wants them."""
    if not slits:
        return np.empty((0, 4))
    corners, owner = np.vstack(slits), np.repeat(np.arange(len(slits)), list(map(len, slits)))
    edges = np.hstack([corners[:-1], corners[1:]])[np.diff(owner) == 0]
    first = np.searchsorted(owner, np.arange(len(slits)), side="left")
    final = np.searchsorted(owner, np.arange(len(slits)), side="right") - 1
    is_open = (corners[first] != corners[final]).any(axis=1)
    last = (final - np.arange(len(slits)) - 1)[is_open]
    tails, middle = edges[last, 2:], (edges[last, :2] + edges[last, 2:]) / 2
    edges[last, 2:] = middle
    return np.vstack([edges, np.hstack([tails, middle])])


def _opened(area: shapely.Geometry, slits: Sequence[FloatArray]) -> shapely.Geometry:
    """`area` less a hair's breadth around each polyline of `slits`, their ends included."""
    if not slits:
        return area
    low, high = np.array(shapely.bounds(area)).reshape(2, 2)
    rounding = float(np.spacing(np.abs([low, high]).max()))
    hair = max(HAIR * float((high - low).max()), HAIR_ROUNDINGS * rounding)
    hairs = shapely.buffer(polylines(slits), hair / 2, cap_style="square", join_style="mitre")
    hairs = shapely.get_parts(shapely.disjoint_subset_union_all(hairs))
    shapely.prepare(area)
    apart = shapely.contains_properly(area, hairs) & (shapely.get_num_interior_rings(hairs) == 0)
    if not apart.all():
        area = shapely.difference(area, shapely.multipolygons(hairs[~apart]))
    pierced = _pierced(area, hairs[apart])
    # Hairs that run into each other may touch others in several corners: they part the floor then, and
    # rings cannot say so.
    if len(hairs) == len(slits) or shapely.is_valid(pierced):
        return pierced
    return shapely.difference(area, shapely.multipolygons(hairs[apart]))


def _pierced(area: shapely.Geometry, holes: FloatArray) -> shapely.Geometry:
    """`area` less `holes` (H,), polygons inside it that touch neither its boundary nor each other.

    They become rings of it as they are, which takes a tenth of the time of a cut.
    """
    parts = shapely.get_parts(area)
    hole, part = shapely.STRtree(parts).query(holes, predicate="within")
    order = np.argsort(part, kind="stable")
    hole, part = hole[order], part[order]
    rings = shapely.get_exterior_ring(holes)
    for k, rows in zip(*np.unique(part, return_index=True), strict=True):
        inner = rings[hole[rows : np.searchsorted(part, k, side="right")]]
        whole = shapely.get_exterior_ring(parts[k])
        parts[k] = shapely.polygons(whole, holes=[*parts[k].interiors, *inner])
    return parts[0] if len(parts) == 1 else shapely.multipolygons(parts)
