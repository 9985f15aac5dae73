"""The free space: where centres of agents may be, before their radius is taken off."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.errors import SceneError
from stplan.maps.floor import read_floor
from stplan.maps.reader import MapError
from stplan.scene.model import Scene


@dataclass(frozen=True)
class FreeSpace:
    """The map as a polygon with its boundary.

    Attributes:
        polygon: shapely Polygon or MultiPolygon, m.
        boundary_vertices: (B, 2) corners of outer rings and holes, m.
        boundary_edges: (E, 2) indices into them.
        triangles: (F, 3, 2) triangles that the map was drawn with, m, None where it has none.
    """

    polygon: shapely.Geometry
    boundary_vertices: FloatArray
    boundary_edges: IntArray
    triangles: FloatArray | None = None

    @staticmethod
    def from_polygon(polygon: shapely.Geometry, triangles: FloatArray | None = None) -> FreeSpace:
        """The free space of a polygon; exactly collinear corners are dropped, order is canonical."""
        polygon = shapely.normalize(shapely.simplify(polygon, 0.0, preserve_topology=True))
        parts = shapely.get_parts(polygon)
        rings = shapely.get_rings(parts[shapely.area(parts) > 0])
        corners, owner = shapely.get_coordinates(rings, return_index=True)
        vertices, place = _distinct(corners)
        edges = np.column_stack([place[:-1], place[1:]])[np.diff(owner) == 0]
        shapely.prepare(polygon)
        edges = np.ascontiguousarray(edges[edges[:, 0] != edges[:, 1]])
        return FreeSpace(polygon, vertices, edges, triangles)

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
    try:
        floor = read_floor(scene.map)
    except MapError as fault:
        raise SceneError(scene.located(fault.path, fault.text)) from fault
    return FreeSpace.from_polygon(floor.area, floor.triangles)
