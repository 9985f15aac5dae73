"""What long work calls on its way: a line about how far it is, and a question whether it should stop."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str], None]
Stop = Callable[[], bool]


def unheard(line: str) -> None:
    """Progress that nobody is shown."""
    del line


def never() -> bool:
    """No request to stop."""
    return False
