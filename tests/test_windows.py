"""What Windows tells of memory, and that all works where a system has no more than Windows has."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from stplan import memory, windows
from stplan.bench import machine

# What the standard library lacks there, taken away before anything of the package is imported. Whoever may
# ask which system this is still hears the truth: other libraries would look for files that are not here.
LACKS = """\
import os, signal, sys
sys.modules["resource"] = sys.modules["fcntl"] = None
for module, names in {
    signal: ["pthread_sigmask", "SIG_BLOCK", "SIG_SETMASK", "SIG_UNBLOCK"],
    os: ["sysconf", "sched_getaffinity", "setpgrp"],
}.items():
    for name in names:
        delattr(module, name)
import multiprocessing
multiprocessing.get_all_start_methods = lambda: ["spawn"]
from stplan.cli.app import main
"""
SCENE = """\
stplan: 1
horizon: 5.0
agents:
  - {id: sam, start: [0.0, 0.0], goal: [4.0, 0.0], radius: 0.25}
"""


class Kernel:
    """The two calls, answered as Windows would, into structures laid out as Windows does."""

    def __init__(self, *, works: bool = True) -> None:
        self.works = works

    def K32GetProcessMemoryInfo(self, process, place, size):  # noqa: N802
        assert process.value == ctypes.c_void_p(-1).value
        assert size == 8 + 8 * ctypes.sizeof(ctypes.c_size_t)
        place._obj.PeakWorkingSetSize = 77 * memory.MIB
        return self.works

    def GlobalMemoryStatusEx(self, place):  # noqa: N802
        assert place._obj.dwLength == 64
        place._obj.ullTotalPhys, place._obj.ullAvailPhys = 8 * 2**30, 3 * 2**30
        return self.works


@pytest.fixture
def kernel(monkeypatch):
    kernel = Kernel()
    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(kernel32=kernel), raising=False)
    monkeypatch.setattr(memory, "resource", None)
    return kernel


def test_memory_is_what_the_system_says(kernel, monkeypatch):
    assert memory.peak() == 77 * memory.MIB
    assert memory.available() == 3 * 2**30
    monkeypatch.delattr(machine.os, "sysconf")
    assert "8 GiB of memory" in machine.description()


def test_a_system_that_does_not_answer_refuses_nothing(kernel):
    kernel.works = False
    assert (memory.peak(), memory.available()) == (0, float("inf"))


def test_no_other_system_is_asked():
    assert windows.peak_memory() == 0
    assert windows.physical_memory() == (float("inf"), float("inf"))


def test_a_batch_is_planned_without_what_windows_lacks(tmp_path):
    scene = tmp_path / "one.yaml"
    scene.write_text(SCENE)
    # Workers import this file anew, as they would there.
    program = tmp_path / "windows.py"
    arguments = ["batch", str(scene), "-o", str(tmp_path / "out"), "--jobs", "1"]
    program.write_text(f"{LACKS}\nif __name__ == '__main__':\n    main({arguments!r})\n")
    root = Path(__file__).parents[1]
    done = subprocess.run(
        [sys.executable, program], capture_output=True, text=True, check=False,
        env={"PYTHONPATH": str(root), "PATH": ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "one" / "trajectories.csv").is_file()
