"""Kernels called on parts of a whole: the same outcome for any number of threads."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from stplan.bench.families_open import crossing_flows
from stplan.geometry.rod_neighbours import near_segments
from stplan.planner import prepare
from stplan.problem.requirement import requirement
from stplan.seeding.elastic_bands.band_neighbours import Bodies, Neighbours, near_rows
from stplan.seeding.elastic_bands.relaxation import relax
from stplan.seeding.elastic_bands.simultaneous import rounds
from stplan.threads import shares, threads, together
from tests.geometry.test_rod_neighbours import random_rods


@pytest.mark.parametrize("count", [1, 2, 3])
def test_parts_come_back_in_their_order_and_the_first_is_done_here(count: int) -> None:
    here = threading.get_ident()
    with threads(count):
        found = together(lambda number: (number, threading.get_ident() == here), [(4,), (5,), (6,)])
    assert [number for number, _ in found] == [4, 5, 6]
    assert [own for _, own in found] == [True, count == 1, count == 1]


def test_an_error_in_any_part_is_raised() -> None:
    def fail(number: int) -> None:
        if number:
            raise ValueError("no")

    with threads(2), pytest.raises(ValueError, match="no"):
        together(fail, [(0,), (1,)])


def test_shares_are_runs_of_about_equal_work() -> None:
    work = np.array([1, 1, 1, 3, 3, 3])
    assert shares(work) == [(0, 6)]
    with threads(2, few=6):
        (_, cut), (begin, past) = shares(work)
        assert cut == begin
        assert past == 6
        assert abs(work[:cut].sum() - work[cut:].sum()) <= 3
        assert shares(work[1:]) == [(0, 5)]
        with threads(1):
            assert shares(work) == [(0, 6)]
    assert shares(work) == [(0, 6)]


@pytest.mark.parametrize("rng_seed", range(3))
def test_near_segments_are_those_that_one_thread_finds(rng_seed: int) -> None:
    rng = np.random.default_rng(rng_seed)
    positions, segments, agents = random_rods(rng, 9, 12)
    collides = ~np.eye(9, dtype=bool)
    reach = np.full((9, 9), 1.5)
    for asked in (None, rng.random(len(segments)) < 0.3):
        alone = near_segments(positions, segments, agents, collides, reach, asked, skin=0.2)
        with threads(3, few=6):
            found = near_segments(positions, segments, agents, collides, reach, asked, skin=0.2)
        assert np.array_equal(found, alone)
        assert len(found) > 20


def test_rows_of_near_segments_are_those_that_one_thread_finds() -> None:
    rng = np.random.default_rng(0)
    positions, segments, agents = random_rods(rng, 9, 12)
    bodies = Bodies(positions, segments, agents, agents != 3)
    collides = ~np.eye(9, dtype=bool)
    reach = np.full((9, 9), 1.5)
    alone = near_rows(bodies, collides, reach, 2.0, skin=0.1)
    with threads(3, few=6):
        found = near_rows(bodies, collides, reach, 2.0, skin=0.1)
    assert all(np.array_equal(one, other) for one, other in zip(found, alone, strict=True))
    assert len(found.members) > 20


def test_bands_move_as_one_thread_moves_them() -> None:
    problem = prepare(crossing_flows(40, 1.0, 3))
    required = requirement(problem, 1.05)
    alone = relax(problem, required, max_sweeps=60)
    with threads(2, few=6):
        found = relax(problem, required, max_sweeps=60)
    assert found.record == alone.record
    assert all(
        np.array_equal(one, other) for one, other in zip(found.curves, alone.curves, strict=True)
    )


def test_those_of_a_round_have_nothing_to_do_with_each_other() -> None:
    rng = np.random.default_rng(0)
    count = 300
    near = rng.random((count, count)) < 0.01
    near |= near.T
    np.fill_diagonal(near, False)
    rows = np.concatenate([[0], np.cumsum(near.sum(axis=1))])
    order = rng.permutation(count)
    place = np.empty(count, dtype=np.int64)
    place[order] = np.arange(count)
    found = rounds(order, Neighbours(rows, np.nonzero(near)[1]))
    moved = np.concatenate([agents for agents, _ in found])
    assert sorted(moved.tolist()) == list(range(count))
    assert any(at_once for _, at_once in found)
    turn = np.empty(count, dtype=np.int64)
    turn[moved] = np.arange(count)
    one, other = np.nonzero(near & (place[:, None] < place[None, :]))
    assert (turn[one] < turn[other]).all()
    for agents, at_once in found:
        assert not (at_once and near[np.ix_(agents, agents)].any())
