"""Kernels called on several parts of a whole at once, each in a thread of its own.

Kernels let go of the interpreter's lock, so that threads share the cores of this machine. Whoever has cores
to spare says so by `threads`; without it everything is done by one thread. Parts must not depend on each
other, and what they lead to comes back in their order: it is the same for any number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from stplan.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

Result = TypeVar("Result")

# Less work than of so many items is not shared out: threads have to be woken up.
FEW_ITEMS = 20_000


class _Crew:
    """`count` threads, this one among them; the others are there once they are needed."""

    def __init__(self, count: int, few: int) -> None:
        self.count, self.few = count, few
        self._pool: ThreadPoolExecutor | None = None

    @property
    def others(self) -> ThreadPoolExecutor:
        """All threads but this one."""
        if self._pool is None:
            from concurrent.futures import ThreadPoolExecutor

            self._pool = ThreadPoolExecutor(self.count - 1)
        return self._pool

    def dismiss(self) -> None:
        """End all threads but this one."""
        if self._pool is not None:
            self._pool.shutdown()


_crew: ContextVar[_Crew | None] = ContextVar("crew", default=None)


@contextmanager
def threads(count: int, few: int = FEW_ITEMS) -> Iterator[None]:
    """Within, kernels are called in `count` threads at once, where they are called on parts.

    Work of less than a `few` items is not shared out.
    """
    crew = _Crew(count, few) if count > 1 else None
    token = _crew.set(crew)
    try:
        yield
    finally:
        _crew.reset(token)
        if crew is not None:
            crew.dismiss()


def num_threads(items: int) -> int:
    """How many threads work on so many items is shared out to."""
    crew = _crew.get()
    return 1 if crew is None or items < crew.few else crew.count


def shares(work: IntArray | FloatArray) -> list[tuple[int, int]]:
    """Items with so much `work` (n,) each, cut into as many runs of about equal work as there are threads."""
    count = num_threads(len(work))
    if count == 1:
        return [(0, len(work))]
    done = np.cumsum(work)
    cuts = np.searchsorted(done, done[-1] * np.arange(1, count) / count) + 1
    edges = np.unique(np.concatenate([[0], cuts, [len(work)]])).tolist()
    return list(pairwise(edges))


def runs(items: int, count: int) -> list[tuple[int, int]]:
    """So many items cut into `count` runs of about equal length."""
    return [(k * items // count, (k + 1) * items // count) for k in range(count)]


def together(function: Callable[..., Result], parts: Sequence[tuple[object, ...]]) -> list[Result]:
    """What `function` makes of the arguments of every one of `parts`, the first one in this thread."""
    crew = _crew.get()
    if crew is None or len(parts) < 2:
        return [function(*part) for part in parts]
    futures = [crew.others.submit(function, *part) for part in parts[1:]]
    return [function(*parts[0]), *(future.result() for future in futures)]
