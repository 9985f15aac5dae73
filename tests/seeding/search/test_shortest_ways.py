"""Shortest ways of discs: as short as can be, clear, through every passage that is wider than they are."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.seeding.search.shortest_ways import WayFinder, walls_kept
from stplan.world import FreeSpace
from tests.seeding.search.exact_ways import shortest_bounds

RADIUS = 0.3


def gap(slack: float) -> FreeSpace:
    """Two rooms and a wall between them, with a gap of 1 + `slack` diameters."""
    half = RADIUS * (1.0 + slack)
    walls = [shapely.box(4.9, 0, 5.1, 3 - half), shapely.box(4.9, 3 + half, 5.1, 6)]
    return FreeSpace.from_polygon(shapely.box(0, 0, 10, 6).difference(shapely.union_all(walls)))


@pytest.mark.parametrize("slack", [0.03, 0.01, 1e-3, 1e-4, 1e-5, 1e-6])
def test_gaps_are_passed_down_to_a_millionth(slack: float) -> None:
    stops = np.array([[1.0, 4.2], [9.0, 1.7]])
    way = WayFinder(gap(slack)).way(stops, RADIUS)
    assert way is not None
    assert way.clearance > RADIUS
    assert np.array_equal(way.points[[0, -1]], stops)


def test_a_gap_as_wide_as_the_disc_is_closed() -> None:
    assert WayFinder(gap(0.0)).way(np.array([[1.0, 4.2], [9.0, 1.7]]), RADIUS) is None


@pytest.mark.parametrize("off", [1e-2, 1e-4, 1e-6])
def test_stops_against_walls_are_reached(off: float) -> None:
    near = RADIUS + off
    stops = np.array([[near, near], [4.9 - near, 6.0 - near], [10.0 - near, 3.0]])
    way = WayFinder(gap(0.2)).way(stops, RADIUS)
    assert way is not None
    assert RADIUS < way.clearance <= near
    assert np.array_equal(way.legs[1][[0, -1]], stops[1:])


def random_floor(rng: np.random.Generator) -> shapely.Geometry:
    middles, sizes = rng.uniform(1, 11, (6, 2)), rng.uniform(0.3, 2.2, (6, 2))
    blocks = shapely.box(*(middles - sizes).T, *(middles + sizes).T)
    return shapely.box(0, 0, 12, 12).difference(shapely.union_all(blocks))


@pytest.mark.parametrize("number", range(10))
def test_one_agent_alone_goes_the_shortest_way_in_a_thousand(number: int) -> None:
    rng = np.random.default_rng([number, 5])
    floor = random_floor(rng)
    finder = WayFinder(FreeSpace.from_polygon(floor))
    inner = shapely.buffer(floor, -1.01 * RADIUS)
    places = [place for place in rng.uniform(0, 12, (80, 2)) if inner.covers(shapely.Point(place))]
    for start, goal in zip(places[:4:2], places[1:4:2], strict=True):
        least, most = shortest_bounds(floor, RADIUS, start, goal, pieces=4)
        way = finder.way(np.stack([start, goal]), RADIUS)
        if way is None:
            assert np.isinf(most)
            continue
        # Of what is left to the optimiser no more than the room at corners.
        assert least * (1.0 - 1e-9) <= way.length
        assert way.length - 0.1 * RADIUS * way.turning <= 1.001 * most


def test_a_narrow_passage_is_not_missed_for_a_wide_detour() -> None:
    # Below the block is a passage with 2 % of slack; the way above is wide, and longer by a metre.
    floor = shapely.box(0, 0, 24, 12).difference(shapely.box(4, 0.816, 20, 10))
    way = WayFinder(FreeSpace.from_polygon(floor)).way(np.array([[2, 5.2], [22, 5.2]]), 0.4)
    assert way is not None
    assert way.points[:, 1].min() < 1.0


def test_walls_are_kept_as_far_off_as_ways_leave() -> None:
    stops = np.array([[1.0, 4.2], [9.0, 1.7]])
    way = WayFinder(gap(1e-3)).way(stops, RADIUS)
    assert way is not None
    radii = np.array([RADIUS, RADIUS])
    kept = walls_kept([way, None], radii, 1.05 * radii)
    assert RADIUS < kept[0] < way.clearance
    assert kept[1] == 1.05 * RADIUS
