"""What those who run runs tell while they do."""

from __future__ import annotations

from dataclasses import dataclass

from stplan.batch.outcome import Outcome

# What a batch that cannot go on leaves its user with.
GO_ON = "the batch ends here; what is finished is written, and the same command goes on from there"


@dataclass(frozen=True)
class Started:
    """A run has begun."""

    run: str


@dataclass(frozen=True)
class Progress:
    """A run says how far it is."""

    run: str
    line: str


@dataclass(frozen=True)
class Finished:
    """A run is over, one way or another."""

    run: str
    outcome: Outcome


Event = Started | Progress | Finished


class Stop:
    """Whether the batch was asked to stop, and how often."""

    def __init__(self) -> None:
        self._times = 0

    def ask(self) -> None:
        """Stop: first politely, the second time at once."""
        self._times += 1

    @property
    def asked(self) -> bool:
        """Begin nothing more."""
        return self._times > 0

    @property
    def at_once(self) -> bool:
        """Wait for nothing more."""
        return self._times > 1
