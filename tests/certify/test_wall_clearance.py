"""Distances to walls against shapely and by hand, and on which side of a wall a path runs."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.certify.box_tree import BoxTree
from stplan.certify.wall_clearance import time_at, wall_distances
from stplan.world import FreeSpace


def pillars(rng: np.random.Generator, side: float, count: int) -> FreeSpace:
    """A square room with so many square pillars a row."""
    place = (np.arange(count) + 0.5) * side / count
    centres = np.column_stack([axis.ravel() for axis in np.meshgrid(place, place)])
    centres += rng.uniform(-0.5, 0.5, centres.shape)
    holes = [shapely.box(x - 0.7, y - 0.4, x + 0.7, y + 0.4).exterior for x, y in centres]
    room = shapely.Polygon(shapely.box(-2, -2, side + 2, side + 2).exterior, holes)
    return FreeSpace.from_polygon(room)


def test_a_tree_holds_every_segment_in_a_box() -> None:
    rng = np.random.default_rng(0)
    for count in (1, 3, 4, 5, 37, 256):
        segments = rng.normal(size=(count, 4))
        tree = BoxTree.over(segments)
        assert sorted(tree.order.tolist()) == list(range(count))
        leaves = len(tree.boxes) // 2
        for place, segment in enumerate(tree.order.tolist()):
            node = leaves + place // 4
            while node:
                for x, y in segments[segment].reshape(2, 2):
                    assert tree.boxes[node, 0] <= x <= tree.boxes[node, 2]
                    assert tree.boxes[node, 1] <= y <= tree.boxes[node, 3]
                node //= 2


@pytest.mark.parametrize("shift", [0.0, 4.6e6])
def test_random_paths_among_pillars(shift: float) -> None:
    rng = np.random.default_rng(2)
    space = pillars(rng, 40.0, 8)
    curves = []
    for _ in range(60):
        knots = rng.integers(1, 12)
        path = np.cumsum(rng.normal(size=(knots, 2)) * rng.choice([0.05, 0.6]), axis=0)
        path += rng.uniform(0.0, 40.0, 2)
        path = np.vstack([path, path[-1:]])
        curves.append(np.column_stack([path, np.arange(knots + 1.0)]))
    away = np.array([shift, -shift, 0.0])
    moved = [curve + away for curve in curves]
    there = FreeSpace.from_polygon(shapely.transform(space.polygon, lambda c: c + away[:2]))
    found = wall_distances(there, moved)
    inside = 0
    for k, curve in enumerate(moved):
        points = shapely.points(curve[:, :2])
        path = shapely.LineString(curve[:, :2])
        if shapely.covers(there.polygon, path):
            inside += 1
            assert found.distance[k] == pytest.approx(
                shapely.distance(path, there.boundary), abs=1e-9
            )
            place = shapely.Point(found.place[k])
            assert place.distance(path) < 1e-8
            assert place.distance(there.boundary) == pytest.approx(found.distance[k], abs=1e-8)
        else:
            depth = shapely.distance(points, there.polygon).max()
            assert found.distance[k] < 0.0
            assert found.distance[k] == pytest.approx(-depth, abs=1e-9)
    assert 10 < inside < 55


def test_of_equal_distances_the_first_wall_and_the_first_time_count() -> None:
    space = FreeSpace.from_polygon(shapely.box(0, 0, 10, 2))
    there_and_back = np.array([[2, 1, 0], [8, 1, 1], [2, 1, 2.0]])
    found = wall_distances(space, [there_and_back])
    assert found.distance.tolist() == [1.0]
    assert found.place.tolist() == [[2.0, 1.0]]


def test_on_the_boundary_through_a_corner_and_out_of_the_room() -> None:
    hole = shapely.box(4, 4, 6, 6)
    space = FreeSpace.from_polygon(shapely.box(0, 0, 10, 10).difference(hole))
    paths = {
        "along a wall": [[1, 0, 0], [9, 0, 1]],
        "at a corner of the hole": [[2, 6, 0], [6, 2, 1]],
        "across the hole": [[2, 5, 0], [8, 5, 1]],
        "over the wall": [[2, 2, 0], [2, 13, 1]],
        "outside": [[12, 2, 0], [13, 2, 1]],
        "in the hole": [[5, 5, 0], [5, 5, 1]],
    }
    found = wall_distances(space, [np.array(path, dtype=float) for path in paths.values()])
    distance = dict(zip(paths, found.distance.tolist(), strict=True))
    assert distance["along a wall"] == 0.0
    assert distance["at a corner of the hole"] == 0.0
    assert -1e-300 < distance["across the hole"] < 0.0
    assert distance["over the wall"] == -3.0
    assert distance["outside"] == -3.0
    assert distance["in the hole"] == -1.0
    places = dict(zip(paths, found.place.tolist(), strict=True))
    assert places["across the hole"] in ([4.0, 5.0], [6.0, 5.0])
    assert places["over the wall"] == [2.0, 13.0]


def test_where_a_path_crosses_a_slanting_wall() -> None:
    hole = shapely.Polygon([(4, 4), (6, 5), (4, 6.5)])
    space = FreeSpace.from_polygon(shapely.box(0, 0, 10, 10).difference(hole))
    path = np.array([[4.5, 1, 0], [5.5, 9, 1.0]])
    found = wall_distances(space, [path])
    assert -1e-300 < found.distance[0] < 0.0
    crossings = shapely.intersection(shapely.LineString(path[:, :2]), hole.exterior)
    nearest = shapely.Point(found.place[0]).distance(crossings)
    assert nearest < 1e-12


@pytest.mark.parametrize(
    ("place", "time"),
    [([-1, 0], 5.0), ([0.4, 3], 5.4), ([2, 1], 7.0), ([3, 1], 9.0), ([9, 0], 11.0)],
)
def test_when_a_path_is_nearest_to_a_place(place: list[float], time: float) -> None:
    curve = np.array([[0, 0, 5], [2, 0, 7], [4, 0, 11.0]])
    assert time_at(curve, np.array(place)) == pytest.approx(time)
