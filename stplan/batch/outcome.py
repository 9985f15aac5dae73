"""How a run ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

# States of a run, and the exit status each of them stands for.
EXIT_STATUS: Mapping[str, int] = {
    "certified": 0,
    "refused": 2,
    "no seed": 3,
    "failed": 4,
    "timeout": 4,
    "out of memory": 4,
    "died": 4,
    "error": 5,
    "interrupted": 130,
    "not run": 130,
}


@dataclass(frozen=True)
class Outcome:
    """What a worker gives back.

    Attributes:
        state: one of `EXIT_STATUS`.
        messages: what a user should know of it, a sentence each.
        files: the run's files by name, in the order to be written; none where nothing was planned.
        seconds: wall time of the attempt.
        traceback: of a bug.
    """

    state: str
    messages: tuple[str, ...] = ()
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    seconds: float = 0.0
    traceback: str = field(default="", repr=False)
