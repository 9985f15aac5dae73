"""Seconds that the stages of planning take; they reach run.json only."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime


class Clock:
    """Seconds by stage, added up where a stage is entered several times."""

    def __init__(self) -> None:
        self.started = datetime.now(UTC)
        self._begin = self._last = time.perf_counter()
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Within, time counts for the stage `name`."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self._last = time.perf_counter()
            self.seconds[name] = self.seconds.get(name, 0.0) + self._last - began

    @property
    def total(self) -> float:
        """From the making of the clock to the end of the latest stage, s."""
        return self._last - self._begin
