"""Areas cut into triangles whose sides match."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from stplan.arrays import FloatArray

# Triangulating takes time that grows with the square of the corners: larger areas are cut into strips of so
# many first.
CORNERS = 500
# Areas up to so many corners stay whole.
FEW = 2_000


def triangles_of(area: shapely.Geometry) -> FloatArray:
    """(F, 3, 2) corners of triangles that cover the polygons of `area`, either way round, m.

    Two triangles that share more than a corner share a side. Corners are those of the area and, of large
    areas, points on their boundaries.
    """
    pieces = area if shapely.get_num_coordinates(area) <= FEW else _strips(area)
    found = shapely.get_parts(shapely.constrained_delaunay_triangles(pieces))
    return np.asarray(shapely.get_coordinates(found).reshape(-1, 4, 2)[:, :3])


def _strips(area: shapely.Geometry) -> NDArray[np.object_]:
    """The area cut across its longer extent; ends of a cut are corners of the pieces on both sides."""
    corners = shapely.get_coordinates(area)
    low, high = corners.min(axis=0), corners.max(axis=0)
    along = int(np.argmax(high - low))
    places = np.sort(corners[:, along])
    strips = -(-len(places) // CORNERS)
    last = np.arange(1, strips) * len(places) // strips
    cuts = np.unique(0.5 * (places[last - 1] + places[last]))
    beyond = high - low
    ends = np.empty((len(cuts), 2, 2))
    ends[:, :, along] = cuts[:, None]
    ends[:, 0, 1 - along], ends[:, 1, 1 - along] = (
        (low - beyond)[1 - along],
        (high + beyond)[1 - along],
    )
    lines = shapely.GeometryCollection([shapely.boundary(area), *shapely.linestrings(ends)])
    pieces = shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.node(lines))))
    shapely.prepare(area)
    return pieces[shapely.contains(area, shapely.point_on_surface(pieces))]
