"""How long whole commands take, beside what loading numpy, scipy.sparse and numba takes on the same machine.

A small scene is planned in less time than its command takes to start, so this is what most users wait for.
Commands and the yardstick take turns, each in a process of its own. Byte code and machine code of kernels are
there already, but for the first compilation, which finds none of the latter.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from stplan.bench.csv_table import csv_table
from stplan.bench.machine import description
from stplan.bench.markdown import table
from stplan.bench.result_files import result_files
from stplan.callbacks import Progress
from stplan.errors import UsageError

ROUNDS, FULL_ROUNDS = 5, 15
FIRST_ROUNDS, FULL_FIRST_ROUNDS = 1, 3
YARDSTICK = "import numpy, scipy.sparse, numba"
YARDSTICK_NAME = f'python -c "{YARDSTICK}"'
FIRST = "first solve, kernels to be compiled"


@dataclass(frozen=True)
class Spent:
    """What a process took, s: by the clock on the wall, and of processors."""

    wall: float
    processor: float


@dataclass(frozen=True)
class Timed:
    """A command in all rounds, and the yardstick beside it; medians."""

    name: str
    runs: tuple[Spent, ...]
    beside: tuple[Spent, ...]

    @property
    def wall(self) -> float:
        """Of the command, s."""
        return median(run.wall for run in self.runs)

    @property
    def processor(self) -> float:
        """Of the command, s."""
        return median(run.processor for run in self.runs)

    @property
    def wall_share(self) -> float:
        """The command's wall time over the yardstick's."""
        return self.wall / median(run.wall for run in self.beside)

    @property
    def processor_share(self) -> float:
        """The command's processor time over the yardstick's."""
        return self.processor / median(run.processor for run in self.beside)


def measure(scene: Path, *, rounds: int, first_rounds: int, progress: Progress) -> list[Timed]:
    """Time the yardstick, help, validation and solution of `scene`, and its first solution.

    Raises:
        UsageError: there is no such scene, or a command fails.
    """
    if not scene.is_file():
        raise UsageError(f"there is no {scene} here; name another scene by --scene")
    with tempfile.TemporaryDirectory(prefix="stplan-bench-") as name:
        folder = Path(name)
        solve = ["solve", str(scene), "--quiet", "-o", str(folder / "runs")]
        commands = {
            "--help": ["--help"],
            "validate": ["validate", str(scene), "--quiet"],
            "solve": solve,
        }
        timed = _rounds(commands, rounds, progress)
        first = []
        for number in range(first_rounds):
            empty = {"NUMBA_CACHE_DIR": str(folder / f"kernels-{number}")}
            first.append(_stplan(solve, empty))
            progress(f"{FIRST}: {first[-1].wall:.2f} s")
    return [*timed, Timed(FIRST, tuple(first), timed[0].beside)]


def _rounds(commands: Mapping[str, Sequence[str]], rounds: int, progress: Progress) -> list[Timed]:
    """The yardstick and the commands in turn, after a first run of each that leaves code for later ones."""
    beside: list[Spent] = []
    runs: dict[str, list[Spent]] = {name: [] for name in commands}
    for words in commands.values():
        _stplan(words)
    for number in range(1, rounds + 1):
        beside.append(_spent(["-c", YARDSTICK]))
        for name, words in commands.items():
            runs[name].append(_stplan(words))
        progress(f"round {number} of {rounds}")
    yardstick = tuple(beside)
    return [
        Timed(YARDSTICK_NAME, yardstick, yardstick),
        *(Timed(name, tuple(spent), yardstick) for name, spent in runs.items()),
    ]


def _stplan(words: Sequence[str], environment: Mapping[str, str] | None = None) -> Spent:
    return _spent(["-m", "stplan", *words], environment)


def _spent(arguments: Sequence[str], environment: Mapping[str, str] | None = None) -> Spent:
    """What this Python takes with `arguments`, in a process of its own.

    Raises:
        UsageError: it fails.
    """
    # Byte code is kept, as it is where a program is installed; and it is this stplan that is timed.
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    package = str(Path(__file__).parents[2])
    paths = os.pathsep.join([package, *filter(None, [kept.get("PYTHONPATH")])])
    started = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, *arguments],
        env={**kept, "PYTHONPATH": paths, **(environment or {})},
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        said = process.stderr.read() if process.stderr else ""
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - started
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise UsageError(f"{' '.join(arguments)} failed: {said.strip()}")
    return Spent(wall, usage.ru_utime + usage.ru_stime)


def files(timed: Sequence[Timed]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    rows = [
        {
            "command": one.name,
            "runs": len(one.runs),
            "wall": one.wall,
            "processor": one.processor,
            "wall_share": one.wall_share,
            "processor_share": one.processor_share,
        }
        for one in timed
    ]
    return result_files("startup", csv_table(rows), markdown_text(timed))


def markdown_text(timed: Sequence[Timed]) -> str:
    """A row a command, and the machine."""
    head = ("command", "runs", "wall s", "processor s", "wall, shares", "processor, shares")
    rows = [
        (
            one.name,
            str(len(one.runs)),
            f"{one.wall:.2f}",
            f"{one.processor:.2f}",
            f"{one.wall_share:.2f}",
            f"{one.processor_share:.2f}",
        )
        for one in timed
    ]
    return "\n".join([table(head, rows), description()])
