"""Steps that pass through something are refused, others are not."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray, IntArray
from stplan.costs.contacts.passage import KEPT_ON_THE_WAY, rods_stay_apart, walls_stay_clear
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.rod_distances import segment_distances
from stplan.geometry.wall_distances import least_wall_distance

PAIR = ~np.eye(2, dtype=bool)


def two_rods(rng: np.random.Generator) -> tuple[FloatArray, IntArray, IntArray]:
    """Positions, segments and agents of two random walks in (x, y, c t) of four segments each."""
    steps = rng.normal(size=(2, 5, 3)) * 0.4 + [0.0, 0.0, 0.8]
    positions = np.cumsum(steps, axis=1).reshape(-1, 3)
    first = np.array([0, 1, 2, 3, 5, 6, 7, 8])
    return positions, np.column_stack([first, first + 1]), first // 5


def gaps_on_the_way(
    start: FloatArray, end: FloatArray, segments: IntArray, agents: IntArray
) -> FloatArray:
    """Least distance of the two rods at many moments of the step."""
    ours, theirs = np.flatnonzero(agents == 0), np.flatnonzero(agents == 1)
    pairs = np.array([(i, j) for i in ours for j in theirs])
    return np.array(
        [
            segment_distances(start + part * (end - start), segments, pairs).min()
            for part in np.linspace(0.0, 1.0, 401)
        ]
    )


def test_rods_are_refused_where_dense_sampling_sees_them_meet() -> None:
    rng = np.random.default_rng(1)
    radius = 0.05
    kept = KEPT_ON_THE_WAY * radius
    outcomes = []
    for _ in range(200):
        start, segments, agents = two_rods(rng)
        end = start + rng.normal(size=start.shape) * rng.choice([0.05, 0.5, 1.5])
        gaps = gaps_on_the_way(start, end, segments, agents)
        if min(gaps[0], gaps[-1]) <= radius:
            continue
        allowed = rods_stay_apart(start, end, segments, agents, PAIR, np.full((2, 2), radius))
        # Sampling misses the least by what happens between two samples.
        between = 2.0 * np.sqrt(((end - start) ** 2).sum(axis=1)).max() / 800
        if allowed:
            assert gaps.min() > 0.5 * kept
        elif gaps.min() > kept:
            assert gaps.min() <= kept + between
        outcomes.append(allowed)
    assert 20 < sum(outcomes) < len(outcomes) - 20


def test_walls_are_refused_where_dense_sampling_sees_a_segment_pass() -> None:
    rng = np.random.default_rng(2)
    edges = np.array([[0.0, -1.0, 0.0, 1.0], [0.0, 1.0, 0.01, 1.0], [0.01, 1.0, 0.0, -1.0]])
    boundary = BoundaryGrid.from_segments(edges)
    radius = 0.02
    pairs = np.array([(0, e) for e in range(3)])
    outcomes = []
    for _ in range(400):
        start, end = rng.normal(size=(2, 1, 2, 2))
        gaps = np.array(
            [
                least_wall_distance(at[:, 0].copy(), at[:, 1].copy(), pairs, edges)
                for at in (start + part * (end - start) for part in np.linspace(0, 1, 401))
            ]
        )
        if min(gaps[0], gaps[-1]) <= radius:
            continue
        allowed = walls_stay_clear(start, end, boundary, np.array([radius]))
        between = np.sqrt(((end - start) ** 2).sum(axis=2)).max() / 800
        if allowed:
            assert gaps.min() > 0.5 * KEPT_ON_THE_WAY * radius
        elif gaps.min() > KEPT_ON_THE_WAY * radius:
            assert gaps.min() <= KEPT_ON_THE_WAY * radius + between
        outcomes.append(allowed)
    assert 20 < sum(outcomes) < len(outcomes) - 20


def test_rods_may_slide_along_themselves_and_all_may_move_together() -> None:
    along = np.column_stack([np.zeros(5), np.zeros(5), np.arange(5.0)])
    start = np.vstack([along, along + np.array([0.2, 0.0, 0.0])])
    segments = np.array([[i, i + 1] for i in (0, 1, 2, 3, 5, 6, 7, 8)])
    agents = np.repeat([0, 1], 4)
    kept = np.full((2, 2), 0.1)
    slid = start + np.where(np.arange(10) < 5, 3.0, 0.0)[:, None] * [0.0, 0.0, 1.0]
    assert rods_stay_apart(start, slid, segments, agents, PAIR, kept)
    assert rods_stay_apart(start, start + 50.0, segments, agents, PAIR, kept)
    through = start + np.where(np.arange(10) < 5, 0.4, 0.0)[:, None] * [1.0, 0.0, 0.0]
    assert not rods_stay_apart(start, through, segments, agents, PAIR, kept)
    nobody = np.zeros((2, 2), dtype=bool)
    assert rods_stay_apart(start, through, segments, agents, nobody, kept)


@pytest.mark.parametrize("jump", [0.5, 50.0, 5000.0])
def test_a_jump_is_seen_however_far_it_leads(jump: float) -> None:
    start = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.1, -1.0, 0.5], [0.1, 1.0, 0.6]])
    segments, agents = np.array([[0, 1], [2, 3]]), np.array([0, 1])
    end = start.copy()
    end[:2, 0] += jump
    thin = np.full((2, 2), 1e-4)
    assert not rods_stay_apart(start, end, segments, agents, PAIR, thin)
    # Past its end.
    end[:2, 1] += 3.0 * jump / min(jump, 0.5)
    start[:2, 1] += 2.0
    assert rods_stay_apart(start, end, segments, agents, PAIR, thin)
