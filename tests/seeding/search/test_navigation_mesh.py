"""Shortest paths in triangulated areas against a visibility graph."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.arrays import FloatArray
from stplan.seeding.search.navigation_mesh import NavigationMesh, shortest_path, triangulated
from tests.seeding.search.exact_ways import visibility_length


def path(mesh: NavigationMesh, start: FloatArray, goal: FloatArray) -> FloatArray:
    tree = shapely.STRtree(shapely.polygons(mesh.corners[mesh.triangles]))
    first, last = (int(tree.nearest(shapely.Point(place))) for place in (start, goal))
    return shortest_path(mesh, start, goal, first, last)


def random_area(rng: np.random.Generator) -> shapely.Geometry:
    area = shapely.box(0, 0, 10, 10)
    for _ in range(rng.integers(2, 12)):
        middle, size = rng.uniform(0, 10, 2), rng.uniform(0.2, 4, 2) / 2
        block = shapely.box(*(middle - size), *(middle + size))
        turn = rng.choice([0.0, 0.5, 0.9])
        matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        turned = shapely.transform(block, lambda xy, m=matrix, c=middle: c + (xy - c) @ m.T)
        area = shapely.difference(area, turned)
    return shapely.buffer(area, -0.1, quad_segs=2)


@pytest.mark.parametrize("number", range(8))
def test_paths_are_the_shortest_there_are(number: int) -> None:
    rng = np.random.default_rng(number)
    area = random_area(rng)
    mesh = triangulated(area)
    places = [place for place in rng.uniform(0, 10, (40, 2)) if area.covers(shapely.Point(place))]
    for start, goal in zip(places[:10:2], places[1:10:2], strict=True):
        exact = visibility_length(area, start, goal)
        found = path(mesh, start, goal)
        if np.isinf(exact):
            assert len(found) == 0
            continue
        line = shapely.LineString(found)
        assert line.length == pytest.approx(exact, rel=1e-9)
        assert shapely.covers(shapely.buffer(area, 1e-9), line)
        assert np.array_equal(found[[0, -1]], [start, goal])


def test_a_path_through_a_crack_turns_at_its_corners() -> None:
    walls = [shapely.box(4, 0, 5, 3 - 1e-8), shapely.box(4, 3 + 1e-8, 5, 6)]
    mesh = triangulated(shapely.difference(shapely.box(0, 0, 9, 6), shapely.union_all(walls)))
    found = path(mesh, np.array([1.0, 1.0]), np.array([8.0, 1.0]))
    expected = 2 * np.hypot(3.0, 2.0 - 1e-8) + 1.0
    assert shapely.LineString(found).length == pytest.approx(expected, abs=1e-9)


def test_parts_without_a_way_between_them_have_none() -> None:
    mesh = triangulated(shapely.union_all([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)]))
    assert len(path(mesh, np.array([0.5, 0.5]), np.array([2.5, 0.5]))) == 0


def test_an_empty_area_has_no_triangles() -> None:
    assert len(triangulated(shapely.Polygon()).triangles) == 0


def test_where_many_ways_are_as_short_one_of_them_is_found() -> None:
    # Between the corners of a city of square blocks there are as many shortest ways as staircases.
    blocks = [
        shapely.box(4 * i + 1, 4 * j + 1, 4 * i + 4, 4 * j + 4) for i in range(4) for j in range(4)
    ]
    area = shapely.difference(shapely.box(0, 0, 17, 17), shapely.union_all(blocks))
    mesh = triangulated(area)
    for goal in ([16.5, 16.5], [16.5, 8.5], [8.5, 12.5]):
        start, end = np.array([0.5, 0.5]), np.array(goal)
        found = path(mesh, start, end)
        assert shapely.LineString(found).length == pytest.approx(
            visibility_length(area, start, end), rel=1e-9
        )
