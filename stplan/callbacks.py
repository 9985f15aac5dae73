"""What long work calls on its way: a line about how far it is, and a question whether it should stop."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

Progress = Callable[[str], None]
Stop = Callable[[], bool]


def unheard(line: str) -> None:
    """Progress that nobody is shown."""
    del line


def never() -> bool:
    """No request to stop."""
    return False


def _unheeded() -> None:
    """Nobody who waits is told why."""


# Called before a kernel is compiled, which takes seconds; where there is machine code already it is not.
COMPILING: ContextVar[Callable[[], None]] = ContextVar("COMPILING", default=_unheeded)
