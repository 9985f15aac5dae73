"""Counting sort, in linear time and without changing the order of equals, and bisection."""

from __future__ import annotations

import numpy as np

from stplan.arrays import IntArray
from stplan.compiled import inner
from stplan.geometry.allocation import new_integers


@inner
def counting_sort(rows: IntArray, num_keys: int) -> tuple[IntArray, IntArray]:
    """Which of `rows` (n, k) have which key, 0..num_keys-1, in their first column.

    Returns:
        starts (num_keys + 1,) and order (n,): rows with key k are
        ``rows[order[starts[k]:starts[k + 1]]]``, in the order they came in.
    """
    starts = new_integers(num_keys + 1)
    for key in range(num_keys + 1):
        starts[key] = 0
    for i in range(len(rows)):
        starts[rows[i, 0] + 1] += 1
    for key in range(num_keys):
        starts[key + 1] += starts[key]
    order = new_integers(len(rows))
    # Every start walks to the end of its rows, which is where the next ones begin.
    for i in range(len(rows)):
        key = rows[i, 0]
        order[starts[key]] = i
        starts[key] += 1
    for key in range(num_keys, 0, -1):
        starts[key] = starts[key - 1]
    starts[0] = 0
    return starts, order


@inner
def sorted_pairs(pairs: IntArray, num_keys: int) -> IntArray:
    """`pairs` (n, 2) by first, then by second entry, each in 0..num_keys-1."""
    turned = np.empty_like(pairs)
    for k in range(len(pairs)):
        turned[k, 0] = pairs[k, 1]
        turned[k, 1] = pairs[k, 0]
    _, order = counting_sort(turned, num_keys)
    result = np.empty_like(pairs)
    for k in range(len(pairs)):
        result[k, 0] = turned[order[k], 1]
        result[k, 1] = turned[order[k], 0]
    _, order = counting_sort(result, num_keys)
    for k in range(len(pairs)):
        turned[k, 0] = result[order[k], 0]
        turned[k, 1] = result[order[k], 1]
    return turned


@inner
def first_at_least(values: IntArray, low: int, high: int, wanted: int) -> int:
    """The first place in the rising ``values[low:high]`` with at least `wanted`, `high` if there is none.

    numpy's own, once compiled, loads scipy.linalg together with the machine code.
    """
    while low < high:
        middle = (low + high) // 2
        if values[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low
