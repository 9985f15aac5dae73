"""A request to stop, from whoever makes it to the work that can answer it.

Work that asks now and then whether it should stop, such as `plan(..., stop=request)` while it improves
curves that are clear already, gives back its best so far. Other work cannot, and is interrupted.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class StopRequest:
    """Counts the requests; called, it says whether there was one.

    The first request is polite where the work has begun to ask, and interrupts where it has not; a second
    one interrupts either. Nothing is interrupted within `held`.
    """

    def __init__(self) -> None:
        self._times = 0
        self._heard = False
        self._holds = 0

    def __call__(self) -> bool:
        """Whether to stop. Whoever asks once is taken to go on asking."""
        self._heard = True
        return self.made

    @property
    def made(self) -> bool:
        """Whether there was a request."""
        return self._times > 0

    def make(self) -> None:
        """Ask the work to stop.

        Raises:
            KeyboardInterrupt: the work does not ask, or was asked before.
        """
        self._times += 1
        if self._holds == 0 and (self._times > 1 or not self._heard):
            raise KeyboardInterrupt

    @contextmanager
    def held(self) -> Iterator[None]:
        """Within, requests are counted and interrupt nothing: a few files are being written, say."""
        self._holds += 1
        try:
            yield
        finally:
            self._holds -= 1
