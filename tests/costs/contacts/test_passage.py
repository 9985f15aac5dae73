"""Steps that pass through something are refused, others are not."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.contacts.passage import KEPT_ON_THE_WAY, rods_stay_apart, walls_stay_clear
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.rod_distances import segment_distances
from stplan.geometry.wall_distances import least_wall_distance
from stplan.problem.layout import KnotLayout
from stplan.problem.rods import Rods

PAIR = ~np.eye(2, dtype=bool)


LAYOUT = KnotLayout.from_offsets(np.array([0, 5, 10]))


def two_rods(rng: np.random.Generator) -> FloatArray:
    """(10, 3) knots of two random walks on in time."""
    steps = rng.normal(size=(2, 5, 3)) * 0.4
    steps[..., 2] = rng.uniform(0.2, 1.2, (2, 5))
    return np.cumsum(steps, axis=1).reshape(-1, 3)


def moved(rng: np.random.Generator, knots: FloatArray, size: float) -> FloatArray:
    """`knots` elsewhere, with times that still run on."""
    other = knots + size * rng.normal(size=knots.shape)
    steps = np.diff(knots[:, 2], prepend=0.0) * rng.uniform(0.5, 2.0, len(knots))
    for own in (slice(0, 5), slice(5, 10)):
        other[own, 2] = other[own, 2].min() + np.cumsum(np.abs(steps[own]))
    return other


def rods_of(knots: FloatArray, stays: tuple[int, ...] = ()) -> Rods:
    """With tails to the 9th second."""
    return Rods.build(LAYOUT, knots, np.array(stays, dtype=np.int64), 9.0, 1.3)


def gaps_on_the_way(rods: Rods, start: FloatArray, end: FloatArray) -> FloatArray:
    """Least distance of the two rods at many moments of the step."""
    ours, theirs = np.flatnonzero(rods.agents == 0), np.flatnonzero(rods.agents == 1)
    pairs = np.array([(i, j) for i in ours for j in theirs])
    return np.array(
        [
            segment_distances(
                rods.positions(start + part * (end - start)), rods.segments, pairs
            ).min()
            for part in np.linspace(0.0, 1.0, 401)
        ]
    )


@pytest.mark.parametrize("stays", [(), (1,), (0, 1)])
def test_rods_are_refused_where_dense_sampling_sees_them_meet(stays: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    radius = 0.05
    kept = KEPT_ON_THE_WAY * radius
    outcomes = []
    for _ in range(100):
        start = two_rods(rng)
        end = moved(rng, start, rng.choice([0.02, 0.3, 0.8]))
        start[[4, 9], :2] = end[[4, 9], :2]  # goals stay where they are
        rods = rods_of(start, stays)
        gaps = gaps_on_the_way(rods, start, end)
        if min(gaps[0], gaps[-1]) <= radius:
            continue
        allowed = rods_stay_apart(rods, start, end, PAIR, np.full((2, 2), radius))
        # Sampling misses the least by what happens between two samples.
        between = 2.0 * 1.3 * np.sqrt(((end - start) ** 2).sum(axis=1)).max() / 800
        if allowed:
            assert gaps.min() > 0.5 * kept
        elif gaps.min() > kept:
            assert gaps.min() <= kept + between
        outcomes.append(allowed)
    assert 10 < sum(outcomes) < len(outcomes) - 10


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


def upright(x: float, y: float = 0.0) -> FloatArray:
    """(5, 3) an agent that stands for four seconds."""
    return np.column_stack([np.full(5, x), np.full(5, y), np.arange(5.0)])


ONE = (np.arange(10) < 5)[:, None]
THIN = np.full((2, 2), 0.1)


def test_rods_may_slide_along_themselves_and_all_may_move_together() -> None:
    start = np.vstack([upright(0.0), upright(0.2)])
    rods = rods_of(start)
    assert rods_stay_apart(rods, start, start + 3.0 * ONE * [0, 0, 1], PAIR, THIN)
    assert rods_stay_apart(rods, start, start + np.array([50.0, 50.0, 0.0]), PAIR, THIN)
    through = start + 0.4 * ONE * [1, 0, 0]
    assert not rods_stay_apart(rods, start, through, PAIR, THIN)
    assert rods_stay_apart(rods, start, through, np.zeros((2, 2), dtype=bool), THIN)


@pytest.mark.parametrize("jump", [0.5, 50.0, 5000.0])
def test_a_jump_is_seen_however_far_it_leads(jump: float) -> None:
    start = np.vstack([upright(0.0), upright(0.3)])
    start[5:, 1] = np.linspace(-1.0, 1.0, 5)
    rods = rods_of(start)
    end = start + jump * ONE * [1, 0, 0]
    assert not rods_stay_apart(rods, start, end, PAIR, 1e-3 * THIN)
    # Past the end of the other one's way.
    around = start + 2.0 * ONE * [0, 1, 0]
    assert rods_stay_apart(rods, around, around + jump * ONE * [1, 0, 0], PAIR, 1e-3 * THIN)


def test_nobody_passes_through_who_stands_on_its_goal() -> None:
    # The second goes by after the first has arrived: through its tail, if it has one.
    start = np.vstack([upright(0.0), upright(-0.5) + np.array([0, 0, 4.5])])
    start[5:, 1] = np.linspace(-1.0, 1.0, 5)
    end = start + 1.0 * ~ONE * [1, 0, 0]
    assert rods_stay_apart(rods_of(start), start, end, PAIR, THIN)
    assert not rods_stay_apart(rods_of(start, (0,)), start, end, PAIR, THIN)
    swapped = np.roll(start, 5, axis=0), np.roll(end, 5, axis=0)
    assert not rods_stay_apart(rods_of(swapped[0], (1,)), *swapped, PAIR, THIN)
