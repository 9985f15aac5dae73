"""Distances around walls, as rounds ask for them."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.replanning.ground import Ground
from stplan.scene import parse_scene
from stplan.world import build_free_space

WALL = """
stplan: 1
horizon: 9
map:
  rectangle: [0, 0, 10, 10]
  obstacles: [{rectangle: [4.9, 0, 5.1, 8]}]
agents: [{id: a, start: [1, 1], goal: [9, 1]}]
"""
RADIUS = 0.4


@pytest.fixture(scope="module")
def ground() -> Ground:
    space = build_free_space(parse_scene(WALL))
    assert space is not None
    return Ground.of(space, RADIUS)


def around(point: tuple[float, float], target: tuple[float, float]) -> float:
    """Over the wall's end by a way that keeps the radius: an upper bound, a little long at the corners."""
    corners = [(4.9 - RADIUS, 8 + RADIUS), (5.1 + RADIUS, 8 + RADIUS)]
    stops = np.array([point, *corners, target])
    return float(np.hypot(*np.diff(stops, axis=0).T).sum())


def test_distances_are_straight_where_a_point_is_seen(ground: Ground) -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform([0.5, 0.5], [4.4, 9.5], (40, 2))
    target = np.array([2.0, 3.0])
    seen = ground.sees(points, np.broadcast_to(target, points.shape))
    assert seen.all()
    assert ground.distances_to(target).at(points) == pytest.approx(np.hypot(*(points - target).T))


@pytest.mark.parametrize("point", [(1.0, 1.0), (4.0, 5.0), (2.0, 7.0)])
def test_distances_lead_around_a_wall(ground: Ground, point: tuple[float, float]) -> None:
    target = (8.0, 2.0)
    found = float(ground.distances_to(np.array(target)).at(np.array([point]))[0])
    assert 0.93 * around(point, target) <= found <= 1.05 * around(point, target)


def test_ways_over_spots_avoid_those_that_may_not_be_used(ground: Ground) -> None:
    """A band of forbidden spots across the left half, with a gap at its end."""
    spots = ground.spots
    usable = ~((np.abs(spots[:, 1] - 5.0) < 1.0) & (spots[:, 0] < 3.0))
    here, there = np.array([1.0, 2.0]), np.array([[1.0, 8.0]])
    free = float(ground.distances_to(here).at(there)[0])
    way = float(ground.distances_to(here, usable).at(there)[0])
    assert free == pytest.approx(6.0)
    assert way > np.hypot(2.0, 2.0) * 2 + 1.9


def test_the_way_begins_where_it_leads(ground: Ground) -> None:
    distances = ground.distances_to(np.array([8.0, 2.0]))
    assert (distances.next_from(np.array([8.0, 5.0])) == [8.0, 2.0]).all()
    here = np.array([3.0, 2.0])
    step = distances.next_from(here) - here
    ahead = distances.at((here + 0.1 * step / np.hypot(*step))[None])[0]
    assert ahead < distances.at(here[None])[0] - 0.09
