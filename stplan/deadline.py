"""The deadline of the work at hand: heeded by work that is long, wherever it is called from.

Whoever limits work says `until` when it may go on. What takes long then looks at the clock at short counted
intervals. Searches stop as if they had found nothing when it has `passed`; work that builds something, of
which a part is of no use, ends by `heed` with an `OutOfTimeError`, which whoever set the deadline catches.
No result depends on the clock but whether there is one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_deadline: ContextVar[float] = ContextVar("deadline", default=float("inf"))


class OutOfTimeError(Exception):
    """The deadline has passed."""


@contextmanager
def until(deadline: float) -> Iterator[None]:
    """Within, `deadline` (s of `working_time`) holds in place of the one before."""
    token = _deadline.set(deadline)
    try:
        yield
    finally:
        _deadline.reset(token)


def passed(ahead: float = 0.0) -> bool:
    """Whether the deadline of the work at hand has passed, or will have in so many seconds."""
    latest = _deadline.get()
    if latest == float("inf"):
        return False
    # Without a deadline, as in validation, there is no need of compiled kernels.
    from stplan.compiled import working_time

    return working_time() + ahead > latest


def heed(ahead: float = 0.0) -> None:
    """Go on unless the deadline has passed.

    Args:
        ahead: how long what comes next takes at least, if it cannot be interrupted, s.

    Raises:
        OutOfTimeError: it has, or would have before that ends.
    """
    if passed(ahead):
        raise OutOfTimeError
