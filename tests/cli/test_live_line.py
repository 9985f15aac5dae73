"""The live line of a terminal: drawn only there, and without any effect on what is planned."""

from __future__ import annotations

import io
import sys

import pytest

from stplan.callbacks import COMPILING
from stplan.cli.command import exit_status
from stplan.cli.console import Console
from stplan.files.csv_file import csv_bytes
from stplan.planner import plan
from stplan.scene import load_scene

SCENE = """\
stplan: 1
name: crossing
horizon: 6.0
agents:
  - {id: sam, start: [-2.0, 0.0], goal: [2.0, 0.1], radius: 0.3}
  - {id: ann, start: [0.1, -2.0], goal: [0.0, 2.0], radius: 0.3}
"""


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def _terminal(monkeypatch: pytest.MonkeyPatch) -> _Terminal:
    """A terminal for stderr; within the test, because pytest sets stderr anew before it."""
    stream = _Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    return stream


def test_on_a_terminal_it_is_said_once_that_kernels_are_compiled(monkeypatch):
    def work(console: Console) -> int:
        for _ in range(3):
            COMPILING.get()()
        return 0

    terminal = _terminal(monkeypatch)
    assert exit_status(work) == 0
    assert terminal.getvalue().count("compiling kernels, once on this machine") == 1
    terminal = _terminal(monkeypatch)
    assert exit_status(work, quiet=True) == 0
    # Nobody listens after the command.
    COMPILING.get()()
    assert terminal.getvalue() == ""
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert exit_status(work) == 0
    assert sys.stderr.getvalue() == ""


def test_drawn_over_and_over_below_what_is_done(monkeypatch):
    terminal = _terminal(monkeypatch)
    console = Console()
    with console.live_line("sam: ") as live:
        assert live is not None
        live(lambda: "outer 1/5  [mu] 0.1")
        console.progress("outer 1/5 done")
    console.progress("after")
    text = terminal.getvalue()
    assert "sam: outer 1/5  [mu] 0.1" in text
    assert " s  " in text
    # The live line is erased before the one that stays is written.
    assert "\x1b[2K" in text[text.index("[mu]") : text.index("outer 1/5 done")]
    assert text.endswith("after\n")


def test_redrawn_no_more_often_than_a_reader_follows(monkeypatch):
    _terminal(monkeypatch)
    made = []
    with Console().live_line() as live:
        assert live is not None
        for number in range(1000):
            live(lambda number=number: made.append(number) or str(number))
    assert made[0] == 0
    assert len(made) < 100


@pytest.mark.parametrize("case", ["quiet", "dumb", "pipe"])
def test_nobody_there_to_read_it(monkeypatch, case):
    stream = io.StringIO() if case == "pipe" else _Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "dumb" if case == "dumb" else "xterm")
    console = Console(quiet=case == "quiet")
    with console.live_line() as live:
        assert live is None
        console.progress("a line")
    assert stream.getvalue() == ("" if case == "quiet" else "a line\n")


def test_solving_tells_every_iteration_and_plans_the_same(tmp_path):
    path = tmp_path / "crossing.yaml"
    path.write_text(SCENE)
    scene = load_scene(path)
    lines: list[str] = []
    watched = plan(scene, live=lambda make: lines.append(make()))
    alone = plan(scene)
    assert watched.trajectories is not None
    assert alone.trajectories is not None
    assert csv_bytes(watched.trajectories) == csv_bytes(alone.trajectories)
    assert watched.run.optimisation is not None
    assert len(lines) > watched.run.optimisation.iterations
    for expected in ("outer 1/", "mu ", "objective ", "clearance ", " iterations"):
        assert expected in lines[0]
