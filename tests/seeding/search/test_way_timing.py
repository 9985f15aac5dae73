"""The earliest arrival along a way, among others whose places are known step by step."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.seeding.search.way_timing import timed_way

WAY = np.column_stack([np.arange(11.0), np.zeros(11)])
LATEST = 1000


def passing(first: int, *, rest: tuple[float, float] = (5.0, 9.0)) -> np.ndarray:
    """Somebody who crosses the way at x = 5 between two steps, and stays off it otherwise."""
    places = np.array([[5.0, 9.0 - 3.0 * min(max(k - first, 0), 6)] for k in range(first + 8)])
    return np.vstack([places, [5.0, -9.0]])[None]


def test_nobody_in_the_way_is_straight_on() -> None:
    arrival, at = timed_way(WAY, np.empty((0, 1, 2)), np.empty(0), LATEST)
    assert arrival == 10
    assert at.tolist() == list(range(11))


def test_who_crosses_is_waited_for_and_kept_off() -> None:
    theirs, apart = passing(2), np.array([1.5])
    arrival, at = timed_way(WAY, theirs, apart, LATEST)
    assert arrival > 10
    assert (np.diff(at) >= 0).all()
    assert (np.diff(at) <= 1).all()
    share = np.linspace(0.0, 1.0, 50)[:, None]
    for k in range(arrival):
        m, n = min(k, theirs.shape[1] - 1), min(k + 1, theirs.shape[1] - 1)
        mine = WAY[at[k]] + share * (WAY[at[k + 1]] - WAY[at[k]])
        other = theirs[0, m] + share * (theirs[0, n] - theirs[0, m])
        assert np.hypot(*(mine - other).T).min() > 1.5


def test_an_end_is_reached_when_it_is_clear_for_good() -> None:
    # Somebody passes by the end late: who arrived before would have to leave.
    theirs = passing(20) + np.array([5.0, 0.0])
    arrival, at = timed_way(WAY, theirs, np.array([1.0]), LATEST)
    assert arrival > 22
    assert at[-1] == 10


@pytest.mark.parametrize("place", [(10.0, 0.5), (4.0, 0.0)])
def test_who_stands_in_the_way_or_at_the_end_for_good_leaves_no_arrival(place) -> None:
    arrival, at = timed_way(WAY, np.array([[place]]), np.array([1.0]), LATEST)
    assert (arrival, len(at)) == (-1, 0)


def test_arrivals_that_are_too_late_are_none() -> None:
    theirs, apart = passing(2), np.array([1.5])
    arrival, _ = timed_way(WAY, theirs, apart, LATEST)
    assert timed_way(WAY, theirs, apart, arrival)[0] == arrival
    assert timed_way(WAY, theirs, apart, arrival - 1)[0] == -1
