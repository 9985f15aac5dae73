"""Counting sort and bisection against numpy's."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.compiled import kernel
from stplan.geometry.sorting import counting_sort, first_at_least, sorted_pairs


@kernel
def sorted_rows(rows: np.ndarray, num_keys: int) -> tuple[np.ndarray, np.ndarray]:
    """`counting_sort`, compiled."""
    return counting_sort(rows, num_keys)


@kernel
def all_sorted(rows: np.ndarray, num_keys: int) -> np.ndarray:
    """`sorted_pairs`, compiled."""
    return sorted_pairs(rows, num_keys)


PAIRS = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=30)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(PAIRS)
def test_rows_of_a_key_keep_their_order(pairs: list[tuple[int, int]]) -> None:
    rows = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    starts, order = sorted_rows(rows, 7)
    assert order.tolist() == np.argsort(rows[:, 0], kind="stable").tolist()
    assert starts.tolist() == np.searchsorted(np.sort(rows[:, 0]), np.arange(8)).tolist()


@settings(max_examples=80, deadline=None, derandomize=True)
@given(PAIRS)
def test_pairs_are_sorted_by_both_entries(pairs: list[tuple[int, int]]) -> None:
    rows = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    assert [tuple(row) for row in all_sorted(rows, 7).tolist()] == sorted(pairs)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(st.lists(st.integers(0, 9), max_size=20), st.integers(-1, 10), st.integers(0, 5))
def test_bisection_finds_what_numpy_finds(values: list[int], wanted: int, low: int) -> None:
    rising = np.sort(np.array(values, dtype=np.int64))
    low = min(low, len(rising))
    expected = low + int(np.searchsorted(rising[low:], wanted))
    assert first_at_least(rising, low, len(rising), wanted) == expected
