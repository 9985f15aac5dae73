"""What is seen of a batch while it runs."""

from __future__ import annotations

import io
import os
import pty
import subprocess
from collections.abc import Iterator
from contextlib import suppress

from rich.console import Console

from stplan.batch.watchers import LineWatcher, TableWatcher
from tests.batch.conftest import COMMAND
from tests.batch.test_formats import result


def test_lines_tell_of_runs_that_are_over_and_of_what_is_wrong():
    said, complained = [], []
    watcher = LineWatcher(said.append, complained.append, verbose=False)
    watcher.begin(12)
    watcher.started("good")
    watcher.progress("good", "outer 1/5")
    watcher.finished(result("good", "certified", "raise solver.max_iterations", seconds=1.5))
    watcher.finished(result("lost", "died", "its worker was killed by SIGKILL"))
    assert said == ["[ 1/12] good: certified, took 1.50 s", "[ 2/12] lost: died"]
    assert complained == ["lost: its worker was killed by SIGKILL"]
    watcher = LineWatcher(said.append, complained.append, verbose=True)
    watcher.progress("good", "outer 2/5")
    assert said[-1] == "good: outer 2/5"


def test_the_table_shows_who_is_at_work_and_who_is_over():
    watcher = TableWatcher()
    watcher.begin(60)
    for number in range(40):
        watcher.started(f"run-{number}")
    watcher.progress("run-3", "outer [1/5]")
    for number in range(12, 22):
        watcher.finished(
            result(f"run-{number}", "certified" if number % 2 else "died", seconds=2.0)
        )
    stream = io.StringIO()
    Console(file=stream, width=80).print(watcher)
    text = stream.getvalue()
    assert "run-3 " in text
    assert "outer [1/5]" in text  # No markup of rich's, whatever it looks like.
    assert "run-21" in text
    assert "run-12" not in text  # Too long ago.
    assert len(text.splitlines()) < 30
    assert text.splitlines()[-1] == "10 of 60 runs: 5 died, 5 certified"


def test_on_a_terminal_there_is_a_table(golden, place):
    golden.copy(place)
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [*COMMAND, "batch", "scenes", "-o", "results"],
        cwd=place, stdout=subprocess.PIPE, stderr=theirs, text=True,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "100"},
    ) as process:  # fmt: skip
        os.close(theirs)
        shown = "".join(_said_to(ours))
        out, _ = process.communicate(timeout=3000)
    os.close(ours)
    assert process.returncode == 0
    assert out.startswith("4 runs: 4 certified (4 done before)\n")
    assert "4 of 4 runs: 4 certified" in shown
    assert "\x1b[" in shown


def _said_to(terminal: int) -> Iterator[str]:
    """All that is written to a terminal until its last writer is gone."""
    with suppress(OSError):  # Linux tells the end by an error.
        while said := os.read(terminal, 2**12):
            yield said.decode(errors="replace")
