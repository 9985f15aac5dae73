"""A binary heap in a plain array, for compiled searches: entries (key, state, count)."""

from __future__ import annotations

from stplan.arrays import IntArray
from stplan.compiled import inner


@inner
def push(heap: IntArray, size: int, key: int, state: int, count: int) -> None:
    """Add an entry to a binary heap of `size` entries (key, state, count), least key first."""
    place = size
    while place > 0:
        above = (place - 1) >> 1
        if heap[above, 0] <= key:
            break
        for column in range(3):
            heap[place, column] = heap[above, column]
        place = above
    heap[place, 0] = key
    heap[place, 1] = state
    heap[place, 2] = count


@inner
def drop_root(heap: IntArray, size: int) -> None:
    """Remove the first entry of a binary heap of `size` entries."""
    size -= 1
    key, state, count = heap[size, 0], heap[size, 1], heap[size, 2]
    place = 0
    while True:
        below = 2 * place + 1
        if below >= size:
            break
        if below + 1 < size and heap[below + 1, 0] < heap[below, 0]:
            below += 1
        if heap[below, 0] >= key:
            break
        for column in range(3):
            heap[place, column] = heap[below, column]
        place = below
    heap[place, 0] = key
    heap[place, 1] = state
    heap[place, 2] = count
