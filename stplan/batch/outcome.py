"""How a run ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class RunState(StrEnum):
    """How a run stands, and the exit status that `stplan solve` would end with.

    Attributes:
        exit_status: the command's.
    """

    exit_status: int

    def __new__(cls, word: str, exit_status: int) -> RunState:
        """A state that equals its `word`, as summaries hold it."""
        state = str.__new__(cls, word)
        state._value_ = word
        state.exit_status = exit_status
        return state

    CERTIFIED = "certified", 0
    REFUSED = "refused", 2
    NO_SEED = "no seed", 3
    FAILED = "failed", 4
    TIMEOUT = "timeout", 4
    OUT_OF_MEMORY = "out of memory", 4
    DIED = "died", 4
    ERROR = "error", 5
    INTERRUPTED = "interrupted", 130
    NOT_RUN = "not run", 130


@dataclass(frozen=True)
class Outcome:
    """What a worker gives back.

    Attributes:
        state: how the attempt ended.
        messages: what a user should know of it, a sentence each.
        files: the run's files by name, in the order to be written; none where nothing was planned.
        seconds: wall time of the attempt.
        traceback: of a bug.
    """

    state: RunState
    messages: tuple[str, ...] = ()
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    seconds: float = 0.0
    traceback: str = field(default="", repr=False)
