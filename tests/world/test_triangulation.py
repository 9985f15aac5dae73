"""Triangles cover an area once, and their sides match."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.world.triangulation import FEW, triangles_of


def floor(pillars: int, corners: int) -> shapely.Polygon:
    """A hall of round pillars, no two sides parallel to the axes."""
    angles = 2 * np.pi * np.arange(corners) / corners
    circle = 0.3 * np.column_stack([np.cos(angles), np.sin(angles)])
    holes = [circle + np.array([i, j]) for i in range(pillars) for j in range(pillars)]
    hall = shapely.box(-1, -1, pillars, pillars).difference(
        shapely.union_all([shapely.Polygon(hole) for hole in holes])
    )
    return shapely.affinity.rotate(hall, 17, origin=(0, 0))


@pytest.mark.parametrize(("pillars", "corners"), [(3, 8), (8, 64)])
def test_the_area_is_covered_once_and_sides_match(pillars: int, corners: int) -> None:
    area = floor(pillars, corners)
    large = shapely.get_num_coordinates(area) > FEW
    assert large == (pillars == 8)
    triangles = triangles_of(area)
    sizes = shapely.area(shapely.polygons(triangles))
    assert sizes.sum() == pytest.approx(area.area, rel=1e-12)
    outside = shapely.difference(shapely.union_all(shapely.polygons(triangles)), area)
    assert outside.area < 1e-9
    sides = np.sort(
        np.unique(triangles.reshape(-1, 2), axis=0, return_inverse=True)[1]
        .reshape(-1, 3)[:, [[0, 1], [1, 2], [2, 0]]]
        .reshape(-1, 2)
    )
    corner_of = np.unique(triangles.reshape(-1, 2), axis=0)
    _, first, count = np.unique(sides, axis=0, return_index=True, return_counts=True)
    assert count.max() == 2
    # Sides of one triangle alone are the area's boundary, no more and no less.
    ends = corner_of[sides[first[count == 1]]]
    assert np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum() == pytest.approx(area.length, rel=1e-9)


def test_nothing_has_no_triangles() -> None:
    assert triangles_of(shapely.Polygon()).shape == (0, 3, 2)
