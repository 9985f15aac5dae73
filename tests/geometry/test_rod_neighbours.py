"""The broad phase of rods against all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray, IntArray
from stplan.geometry.rod_neighbours import near_segments
from tests.geometry.points import apart_squared


def random_rods(
    rng: np.random.Generator, count: int, num: int
) -> tuple[FloatArray, IntArray, IntArray]:
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
        [i, j]
        for i in range(len(segments))
        for j in range(len(segments))
        if agents[i] < agents[j]
        and collides[agents[i], agents[j]]
        and apart_squared(*positions[segments[i]], *positions[segments[j]])
        < reach[agents[i], agents[j]] ** 2
    ]
    found = near_segments(positions, segments, agents, collides, reach)
    assert found.tolist() == expected
    assert len(expected) > 20
    assert (
        near_segments(
            positions, segments, agents, collides, 0.5 * reach - 0.1, factor=2.0, skin=0.2
        ).tolist()
        == expected
    )
    asked = rng.random(len(segments)) < 0.3
    some = near_segments(positions, segments, agents, collides, reach, asked)
    assert some.tolist() == [pair for pair in expected if asked[pair].any()]
    assert 0 < len(some) < len(expected)


def test_more_pairs_than_there_was_room_for() -> None:
    count = 40
    start = np.column_stack([np.zeros((count, 2)), np.arange(count) * 1e-3])
    positions = np.vstack([start, start + np.array([0, 0, 1.0])])
    segments = np.column_stack([np.arange(count), np.arange(count) + count])
    found = near_segments(
        positions, segments, np.arange(count), ~np.eye(count, dtype=bool), np.ones((count, count))
    )
    assert len(found) == count * (count - 1) // 2


def test_nobody_collides() -> None:
    positions, segments, agents = random_rods(np.random.default_rng(0), 3, 4)
    found = near_segments(positions, segments, agents, np.zeros((3, 3), bool), np.ones((3, 3)))
    assert found.shape == (0, 2)
