"""Signals that wait for a while. Windows has no masks: there nothing is held back, and nothing is lost."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

_HAS_MASKS = hasattr(signal, "pthread_sigmask")


@contextmanager
def held(*numbers: signal.Signals) -> Iterator[None]:
    """Within, `numbers` are not delivered to this thread, nor to a process that it starts."""
    if not _HAS_MASKS:
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def release(*numbers: signal.Signals) -> None:
    """Deliver `numbers` from here on, which whoever started this process held."""
    if _HAS_MASKS:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, numbers)
