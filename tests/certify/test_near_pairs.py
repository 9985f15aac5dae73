"""No pair that comes near is missed, and few others are looked at."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.near_pairs import near_pairs
from stplan.certify.pair_clearance import nearest_moments
from stplan.problem.world_lines import WorldLines
from tests.certify.crowds import walkers, wanderers


def near(lines, leaves, wanted, halves) -> tuple[set[tuple[int, int]], set[tuple[int, int]]]:
    """The pairs that brute force finds near, and those that are looked at."""
    found = nearest_moments(lines, leaves, wanted)
    close = found.distance <= halves[found.pairs].sum(axis=1)
    looked_at = near_pairs(lines, leaves, wanted, halves, 1e-12)
    assert looked_at.tolist() == sorted(looked_at.tolist())
    assert (looked_at[:, 0] < looked_at[:, 1]).all()
    pairs = [tuple(pair) for pair in looked_at.tolist()]
    assert len(set(pairs)) == len(pairs)
    return {tuple(pair) for pair in found.pairs[close].tolist()}, set(pairs)


@pytest.mark.parametrize("seed", range(12))
def test_every_pair_that_comes_near_is_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 60
    lines = wanderers(count, rng)
    # Most are small, a few are wider than half the place.
    halves = rng.choice([0.1, 0.5, 20.0], count, p=[0.6, 0.35, 0.05])
    leaves = lines.knots[lines.offsets[1:] - 1, 2] + rng.choice([0.0, 30.0], count)
    wanted = rng.random((count, count)) < 0.8
    wanted |= wanted.T
    np.fill_diagonal(wanted, False)
    expected, looked_at = near(lines, leaves, wanted, halves)
    assert expected
    assert expected <= looked_at
    assert all(wanted[pair] for pair in looked_at)


@pytest.mark.parametrize("quarters", range(4))
def test_touching_boxes_count(quarters: int) -> None:
    # They come to exactly the sum of both, at an instant, at a knot of both; from every side.
    turn = np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), quarters)
    curves = [
        np.array([[0, 0, 0], [4, 1, 5], [8, 0, 10.0]]),
        np.array([[0, 3, 0], [4, 2, 5], [8, 3, 10.0]]),
    ]
    for curve in curves:
        curve[:, :2] = curve[:, :2] @ turn.T
    lines = WorldLines.from_curves(["a", "b"], curves)
    wanted = ~np.eye(2, dtype=bool)
    leaves = np.array([10.0, 10.0])
    assert near_pairs(lines, leaves, wanted, np.array([0.5, 0.5])).tolist() == [[0, 1]]
    assert not len(near_pairs(lines, leaves, wanted, np.array([0.01, 0.01])))


def test_who_leaves_when_another_comes_is_near_it() -> None:
    stand = np.array([[0, 0, 0], [0, 0, 1.0]])
    later = np.array([0.0, 0.0, 1.0])
    lines = WorldLines.from_curves(["a", "b", "c"], [stand, stand + 2.0 * later, stand + later])
    wanted, halves = ~np.eye(3, dtype=bool), np.full(3, 0.5)
    expected, looked_at = near(lines, np.array([1.0, 3.0, 2.0]), wanted, halves)
    assert expected == {(0, 2), (1, 2)}
    assert expected <= looked_at
    expected, looked_at = near(lines, np.array([6.0, 8.0, 7.0]), wanted, halves)
    assert expected == looked_at == {(0, 1), (0, 2), (1, 2)}


def test_crowds_in_clusters_far_apart() -> None:
    rng = np.random.default_rng(3)
    lines = walkers(300, rng)
    lines.knots[: lines.offsets[150], :2] += [3e5, -2e5]
    wanted, halves = ~np.eye(300, dtype=bool), np.full(300, 0.4)
    expected, looked_at = near(lines, lines.knots[lines.offsets[1:] - 1, 2], wanted, halves)
    assert expected <= looked_at
    assert len(looked_at) < 8 * len(expected)


def test_at_constant_density_the_pairs_looked_at_grow_with_the_agents() -> None:
    def a_pair_each(count: int) -> float:
        lines = walkers(count, np.random.default_rng(count))
        wanted, halves = np.ones((count, count), dtype=bool), np.full(count, 0.4)
        found = near_pairs(lines, lines.knots[lines.offsets[1:] - 1, 2], wanted, halves)
        return len(found) / count

    few, many = a_pair_each(500), a_pair_each(4000)
    assert 0.7 < many / few < 1.3
    assert many < 20
