"""Points that graphs are made of: inside, apart, off the walls, and linked without holes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.world.sampling import (
    along,
    box_around,
    delaunay_edges,
    hexagonal_points,
    points_of_rings,
    rings_of,
    rings_off_the_walls,
    thinned,
    ties,
)

ROOM = shapely.box(0, 0, 10, 6).difference(shapely.box(4, 2, 6, 4))


def test_the_lattice_lies_inside_and_leaves_no_hole() -> None:
    points = hexagonal_points(ROOM, 0.5)
    assert shapely.contains_xy(ROOM, points[:, 0], points[:, 1]).all()
    # Its triangles have sides of one spacing, so nothing inside is further off than this.
    inner = ROOM.buffer(-0.5)
    discs = shapely.buffer(shapely.points(points), 0.5 / np.sqrt(3) + 1e-2)
    left = inner.difference(shapely.union_all(discs))
    assert left.area < 1e-2
    assert hexagonal_points(shapely.Polygon(), 0.5).shape == (0, 2)


def test_rings_keep_off_the_walls_and_follow_them() -> None:
    radius = 0.4
    rings = rings_off_the_walls(ROOM, radius)
    assert len(rings) == 2
    for ring in rings:
        line = shapely.LineString(ring)
        assert line.distance(ROOM.boundary) > radius
        assert max(shapely.distance(shapely.points(ring), ROOM.boundary)) < 1.1 * radius * np.sqrt(
            2
        )
    assert rings_off_the_walls(ROOM, 2.0) == []
    assert points_of_rings([], 0.1).shape == (0, 2)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.floats(0.05, 3.0))
def test_points_along_a_ring_are_no_further_apart_than_asked(step: float) -> None:
    for ring in rings_of(ROOM):
        points = along(ring, step)
        gaps = np.hypot(*np.diff(np.vstack([points, points[:1]]), axis=0).T)
        assert gaps.max() <= step * (1 + 1e-12)
        corners = {tuple(corner) for corner in ring.tolist()}
        assert corners <= {tuple(point) for point in points.tolist()}


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(st.integers(0, 9), st.integers(0, 9), st.sampled_from([0.0, 0.5, 1.5, 4.0])),
        min_size=1,
        max_size=25,
    )
)
def test_thinning_keeps_the_first_of_those_that_are_near(
    rows: list[tuple[int, int, float]],
) -> None:
    table = np.array(rows, dtype=np.float64)
    points, apart = table[:, :2], table[:, 2]
    kept: list[int] = []
    for k in range(len(points)):
        gaps = np.hypot(*(points[kept] - points[k]).T)
        if apart[k] == 0 or not (gaps <= apart[k]).any():
            kept.append(k)
    assert np.array_equal(thinned(points, apart), points[kept])


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_the_triangulation_is_the_same_far_from_the_origin(offset: float) -> None:
    points = np.random.default_rng(0).uniform(0, 10, (400, 2))
    edges = delaunay_edges(points)
    # Euler: a triangulation of n points, h of them on the hull, has 3 n - 3 - h edges.
    hull = len(shapely.convex_hull(shapely.multipoints(points)).exterior.coords) - 1
    assert len(edges) == 3 * 400 - 3 - hull
    assert (edges[:, 0] < edges[:, 1]).all()
    assert np.array_equal(delaunay_edges(points + offset), edges)


def test_points_on_a_line_are_linked_along_it() -> None:
    line = np.array([[0.0, 0], [2, 2], [1, 1], [3, 3]])
    assert delaunay_edges(line).tolist() == [[0, 2], [1, 2], [1, 3]]
    assert delaunay_edges(line[:2]).tolist() == [[0, 1]]
    assert delaunay_edges(line[:1]).shape == (0, 2)


def test_places_are_tied_to_those_around_them() -> None:
    vertices = np.array([[0.0, 0], [1, 0], [2, 0], [3, 0], [4, 0]])
    assert sorted(map(tuple, ties(np.array([0, 3]), vertices, 2).tolist())) == [
        (0, 1), (0, 2), (3, 2), (3, 4),
    ]  # fmt: skip
    assert ties(np.array([0]), vertices[:1], 3).shape == (0, 2)


def test_a_box_has_room_around_the_places() -> None:
    box = box_around(np.array([[0.0, 0], [10, 2]]), 3.0)
    assert box.bounds == (-4.0, -4.0, 14.0, 6.0)
