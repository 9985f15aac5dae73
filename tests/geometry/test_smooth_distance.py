"""Distances and neighbour lists against brute force and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from stplan.geometry.boundary_grid import BoundaryGrid, crossings
from stplan.geometry.rod_neighbours import near_segments
from stplan.geometry.segments import closest_parameters, squared_distance


def brute_squared_distance(p0, p1, q0, q1) -> float:
    """By a bounded minimiser from the best of a grid."""
    u, v, r = p1 - p0, q1 - q0, p0 - q0

    def gap(z):
        return float(((r + z[0] * u - z[1] * v) ** 2).sum())

    grid = [(s, t) for s in np.linspace(0, 1, 11) for t in np.linspace(0, 1, 11)]
    start = min(grid, key=gap)
    return min(
        gap(start), minimize(gap, start, bounds=[(0, 1), (0, 1)], options={"ftol": 1e-15}).fun
    )


def test_segment_distance_equals_a_minimiser() -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        p0, p1, q0, q1 = rng.normal(size=(4, 3))
        s, t, squared = closest_parameters(*p0, *p1, *q0, *q1)
        assert 0 <= s <= 1
        assert 0 <= t <= 1
        assert squared == pytest.approx(brute_squared_distance(p0, p1, q0, q1), abs=1e-7)


def test_segment_distance_of_points_and_parallels() -> None:
    assert squared_distance(0, 0, 0, 0, 0, 0, 3, 4, 0, 3, 4, 0) == 25
    assert squared_distance(1, 2, 0, 1, 2, 0, 0, 0, 0, 4, 0, 0) == 4
    s, t, squared = closest_parameters(0, 0, 0, 4, 0, 0, 1, 1, 0, 7, 1, 0)
    assert squared == 1
    assert s == pytest.approx(0.625)  # the middle of the overlap [1, 4]
    assert t == pytest.approx(0.25)


def test_segment_distance_is_symmetric_and_rigid() -> None:
    rng = np.random.default_rng(1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    for _ in range(50):
        p0, p1, q0, q1 = points = rng.normal(size=(4, 3))
        there = squared_distance(*p0, *p1, *q0, *q1)
        assert squared_distance(*q0, *q1, *p1, *p0) == pytest.approx(there)
        moved = points @ turn + [3.0, -1.0, 2.0]
        assert squared_distance(*moved.ravel()) == pytest.approx(there)


def random_rods(rng: np.random.Generator, count: int, num: int):
    """Random walks of `count` agents with `num` segments each."""
    curves = rng.uniform(0, 4, (count, 1, 3)) + np.cumsum(
        rng.normal(size=(count, num + 1, 3)) + np.array([0, 0, 0.7]), axis=1
    )
    first = (np.arange(count)[:, None] * (num + 1) + np.arange(num)).ravel()
    return (
        curves.reshape(-1, 3),
        np.column_stack([first, first + 1]),
        np.repeat(np.arange(count), num),
    )


@pytest.mark.parametrize("rng_seed", range(5))
def test_near_segments_equal_brute_force(rng_seed: int) -> None:
    rng = np.random.default_rng(rng_seed)
    positions, segments, agents = random_rods(rng, 9, 12)
    # A long upright tail among short segments.
    positions = np.vstack([positions, positions[segments[11, 1]] + [0, 0, 60.0]])
    segments = np.vstack([segments, [segments[11, 1], len(positions) - 1]])
    agents = np.append(agents, agents[11])
    collides = rng.random((9, 9)) < 0.7
    collides = (collides | collides.T) & ~np.eye(9, dtype=bool)
    reach = rng.uniform(0.3, 2.0, (9, 9))
    reach = np.maximum(reach, reach.T)
    expected = [
        (i, j)
        for i in range(len(segments))
        for j in range(len(segments))
        if agents[i] < agents[j]
        and collides[agents[i], agents[j]]
        and squared_distance(*positions[segments[i]].ravel(), *positions[segments[j]].ravel())
        < reach[agents[i], agents[j]] ** 2
    ]
    found = near_segments(positions, segments, agents, collides, reach)
    assert found.tolist() == [list(pair) for pair in expected]
    assert len(expected) > 20


@pytest.mark.parametrize("rng_seed", range(3))
def test_boundary_grid_misses_no_near_edge(rng_seed: int) -> None:
    rng = np.random.default_rng(rng_seed)
    edges = rng.uniform(0, 10, (60, 2))
    edges = np.hstack([edges, edges + rng.normal(size=(60, 2))])
    starts = rng.uniform(-2, 12, (40, 2))
    ends = starts + rng.normal(size=(40, 2))
    reach = rng.uniform(0.1, 1.0, 40)
    segment, edge = BoundaryGrid(edges).near(starts, ends, reach)
    found = set(zip(segment.tolist(), edge.tolist(), strict=True))
    for k in range(40):
        for e in range(60):
            gap = squared_distance(*starts[k], 0, *ends[k], 0, *edges[e, :2], 0, *edges[e, 2:], 0)
            if gap < reach[k] ** 2:
                assert (k, e) in found


def test_crossings_agree_with_zero_distance() -> None:
    rng = np.random.default_rng(4)
    starts, ends = rng.uniform(0, 4, (2, 300, 2))
    edges = rng.uniform(0, 4, (300, 4))
    index = np.arange(300)
    crossed = crossings(starts, ends, index, index, edges)
    touching = [
        squared_distance(*starts[k], 0, *ends[k], 0, *edges[k, :2], 0, *edges[k, 2:], 0) < 1e-18
        for k in range(300)
    ]
    assert crossed.tolist() == touching
    assert 30 < crossed.sum() < 200
