"""Someone looks on while a batch runs: through plain lines, or through a table on a terminal."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from stplan.batch.result import Result
from stplan.callbacks import Progress

# Rows of runs that are over.
_LAST = 8
# Rows of runs at work; a cluster is given all at once.
_MOST_AT_WORK = 16


class LineWatcher:
    """One line for every run that is over, then its complaints; with `verbose` all it says before."""

    def __init__(self, say: Progress, complain: Progress, verbose: bool) -> None:
        self._say = say
        self._complain = complain
        self._verbose = verbose
        self._total = self._over = 0

    def begin(self, total: int) -> None:
        """The batch has so many runs."""
        self._total = total

    def started(self, run: str) -> None:
        """A run has begun."""
        if self._verbose:
            self._say(f"{run}: begun")

    def progress(self, run: str, line: str) -> None:
        """A run says how far it is."""
        if self._verbose:
            self._say(f"{run}: {line}")

    def finished(self, result: Result) -> None:
        """A run is over."""
        self._over += 1
        width = len(str(self._total))
        self._say(f"[{self._over:{width}}/{self._total}] {result.sentence}")
        for line in result.complaints:
            self._complain(line)


class TableWatcher:
    """A table that is redrawn: the runs at work, the last that are over, and the counts."""

    def __init__(self) -> None:
        self._total = 0
        self._states: Counter[str] = Counter()
        self._at_work: dict[str, tuple[float, str]] = {}
        self._last: deque[Result] = deque(maxlen=_LAST)

    def begin(self, total: int) -> None:
        """The batch has so many runs."""
        self._total = total

    def started(self, run: str) -> None:
        """A run has begun."""
        self._at_work[run] = time.monotonic(), ""

    def progress(self, run: str, line: str) -> None:
        """A run says how far it is."""
        self._at_work[run] = self._at_work[run][0], line

    def finished(self, result: Result) -> None:
        """A run is over."""
        self._at_work.pop(result.run.name, None)
        self._states[result.state] += 1
        self._last.append(result)

    def __rich__(self) -> RenderableType:
        table = Table(box=None, pad_edge=False)
        table.add_column("run", overflow="fold")
        table.add_column("s", justify="right")
        table.add_column("state", no_wrap=True, overflow="ellipsis")
        for result in self._last:
            spent = f"{result.seconds:.1f}" if result.fresh and result.seconds is not None else ""
            state = result.sentence.removeprefix(f"{result.run.name}: ")
            style = "green" if result.exit_status == 0 else "red"
            # As Text: the names and messages are not meant to be read as rich's markup.
            table.add_row(Text(result.run.name), spent, Text(state, style))
        # A copy: the table is drawn by another thread.
        for run, (since, line) in list(self._at_work.items())[:_MOST_AT_WORK]:
            table.add_row(Text(run), f"{time.monotonic() - since:.1f}", Text(line or "..."))
        over = sum(self._states.values())
        counts = ", ".join(f"{number} {state}" for state, number in self._states.items())
        return Group(table, Text(f"{over} of {self._total} runs{': ' if counts else ''}{counts}"))


@contextmanager
def live_table() -> Iterator[TableWatcher]:
    """A table on the terminal behind stderr."""
    watcher = TableWatcher()
    console = Console(stderr=True)
    with Live(watcher, console=console, refresh_per_second=4, redirect_stdout=False):
        yield watcher
