"""What the commands say and where: results to stdout, progress and messages to stderr."""

from __future__ import annotations

import math
import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

from stplan.errors import UsageError, as_stplan_error
from stplan.files.json_file import json_bytes

if TYPE_CHECKING:
    from rich.console import Console as Terminal
    from rich.live import Live
    from rich.text import Text

# The worst of several scenes is the command's: a bug, a broken command line or scene, ...
_WORST_FIRST = (5, 130, 2, 3, 4, 1, 0)

_REDRAW_SECONDS = 0.1


def worst(statuses: list[int]) -> int:
    """The exit status of a command that did several things."""
    return min(statuses, key=_WORST_FIRST.index, default=0)


class Console:
    """Where a command's words go, by how much was asked for.

    Args:
        quiet: errors only.
        verbose: more detail, progress with seconds.
        as_json: one JSON object instead of a text on stdout.
    """

    def __init__(self, quiet: bool = False, verbose: bool = False, as_json: bool = False) -> None:
        if quiet and verbose:
            raise UsageError("--quiet and --verbose exclude each other")
        self.quiet = quiet
        self.verbose = verbose
        self.as_json = as_json
        self._started = time.monotonic()
        self._live: Live | None = None
        # Whether it has been said, or need not be, that kernels are compiled.
        self.expects_compiling = False

    def result(self, *lines: str) -> None:
        """Text on stdout, unless --quiet or --json."""
        if not self.quiet and not self.as_json and lines:
            write(sys.stdout, "\n".join(lines) + "\n")

    def result_json(self, content: dict[str, Any]) -> None:
        """The one object on stdout, with --json."""
        if self.as_json:
            write(sys.stdout, json_bytes(content).decode())

    def progress(self, line: str) -> None:
        """A line on stderr, unless --quiet; above the live line, and with its time, where there is one."""
        if self._live is not None:
            self._live.update("")
            self._live.console.print(self._timed(line))
        elif not self.quiet:
            seconds = f"[{time.monotonic() - self._started:7.2f} s] " if self.verbose else ""
            write(sys.stderr, f"{seconds}{line}\n")

    def compiling(self) -> None:
        """Why the first run on a machine takes longer; once, and to people only."""
        if not self.expects_compiling and sys.stderr is not None and sys.stderr.isatty():
            self.progress(
                "compiling kernels, once on this machine (`stplan doctor --compile` does it ahead)"
            )
        self.expects_compiling = True

    @contextmanager
    def live_line(self, prefix: str = "") -> Iterator[Callable[[Callable[[], str]], None] | None]:
        """A line at the foot of the terminal that is drawn anew with what happens.

        Gives a function to call with a maker of the line, which is called in turn as often as a reader
        can follow; or None where stderr is no terminal, or with --quiet: there is nobody to read it.
        """
        terminal = None if self.quiet else _terminal()
        if terminal is None:
            yield None
            return
        from rich.live import Live

        drawn = -math.inf

        def draw(make: Callable[[], str]) -> None:
            nonlocal drawn
            now = time.monotonic()
            if now - drawn >= _REDRAW_SECONDS:
                drawn = now
                live.update(self._timed(prefix + make()), refresh=True)

        with Live(console=terminal, auto_refresh=False, transient=True) as live:
            self._live = live
            try:
                yield draw
            finally:
                self._live = None

    def _timed(self, line: str) -> Text:
        """A line headed by the seconds since the start, whatever letters it is made of."""
        from rich.text import Text

        seconds = f"{time.monotonic() - self._started:6.1f} s  "
        return Text.assemble((seconds, "dim"), line)

    def error(self, *lines: str) -> None:
        """What went wrong, on stderr, always."""
        if lines:
            write(sys.stderr, "\n".join(lines) + "\n")

    def hint(self, line: str) -> None:
        """Where an error is explained, on stderr, unless --quiet."""
        if not self.quiet:
            write(sys.stderr, f"{line}\n")


def _terminal() -> Terminal | None:
    """The terminal behind stderr, None where it is a file, a pipe or too simple to draw anew."""
    if sys.stderr is None or not sys.stderr.isatty():
        return None
    from rich.console import Console as Terminal

    terminal = Terminal(file=sys.stderr, highlight=False, emoji=False, markup=False)
    return None if terminal.is_dumb_terminal else terminal


def write(stream: TextIO | None, text: str) -> None:
    """Write at once. A reader that has gone away (`| head`) is no reason to stop working.

    Raises:
        UsageError: stdout leads to a full disk.
    """
    if stream is None:
        return
    try:
        stream.write(text)
        stream.flush()
    except OSError as error:
        # From here on to nowhere, or the interpreter would complain once more when it ends.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        if not isinstance(error, BrokenPipeError) and stream is sys.stdout:
            raise UsageError(f"cannot write to standard output: {error.strerror}") from error


def failure(error: BaseException) -> tuple[int, list[str]]:
    """Exit status and messages of an exception; a bug's traceback goes to a file."""
    known = as_stplan_error(error)
    if known is not None:
        return known.exit_status, str(known).splitlines() or [type(known).__name__]
    what = " ".join(f"{type(error).__name__}: {error}".split())
    return 5, [f"internal error: {what}; {_save_traceback(error)}"]


def further_reading(error: BaseException) -> list[str]:
    """The line that names the page of the documentation on an error, where there is one."""
    known = as_stplan_error(error)
    return [f"more on this: {known.page}"] if known is not None and known.page else []


def _save_traceback(error: BaseException) -> str:
    text = "".join(traceback.format_exception(error))
    try:
        descriptor, name = tempfile.mkstemp(prefix="stplan-traceback-", suffix=".txt")
        with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as stream:
            stream.write(text)
    except OSError as problem:
        return f"the traceback could not be saved: {problem.strerror or problem}"
    return f"traceback saved to {name}"


def note_failure(
    console: Console, record: dict[str, Any], error: BaseException, prefix: str = ""
) -> None:
    """Say what an exception means for one of several things that a command does, and note it."""
    status, messages = failure(error)
    console.error(*(prefix + message for message in messages))
    for line in further_reading(error):
        console.hint(prefix + line)
    record |= {"exit_status": status, "status": "error", "messages": messages}
