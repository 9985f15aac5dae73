"""Small scenes, batches of them in processes of their own, and what never may differ."""

from __future__ import annotations

import csv
import io
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from stplan.files.manifest import why_incomplete
from tests.cli.conftest import run

__all__ = ["run"]

COMMAND = [sys.executable, "-m", "stplan"]
RUN_FILES = {
    "trajectories.csv", "trajectories.npz", "seed.csv", "seed.npz", "report.json", "run.json",
}  # fmt: skip
ENDLESS = ["--set", "solver.outer_iterations=1000", "--set", "solver.mu_decay=0.999"]

CROSSING = """\
stplan: 1
horizon: 6.0
agents:
  - {{id: sam, start: [-2.0, {offset}], goal: [2.0, 0.1], radius: 0.3, mass: 70.0}}
  - {{id: ann, start: [0.1, -2.0], goal: [0.0, 2.0], radius: 0.3, mass: 50.0}}
"""
ROOM = """\
stplan: 1
horizon: 12.0
map: {mesh: room.obj}
agents:
  - {id: sam, start: [1.0, 1.0], goal: [5.0, 2.0], radius: 0.3}
  - {id: ann, start: [5.0, 1.0], goal: [1.0, 2.0], radius: 0.3}
"""
MESH = "v 0 0 0\nv 6 0 0\nv 6 3 0\nv 0 3 0\nf 1 2 3 4\n"


@dataclass
class Ended:
    """How a command ended."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


def stplan(*arguments: object, cwd: Path, **environment: str) -> Ended:
    """Run a command in a process of its own."""
    done = subprocess.run(
        [*COMMAND, *map(str, arguments)],
        cwd=cwd, env=os.environ | environment, capture_output=True, text=True, check=False,
        timeout=3000,
    )  # fmt: skip
    return Ended(done.returncode, done.stdout, done.stderr)


def write_scenes(folder: Path) -> None:
    """Four scenes: three in the open plane, one in a room that is a mesh."""
    folder.mkdir(parents=True)
    for number, name in enumerate(("one", "two", "three")):
        (folder / f"{name}.yaml").write_text(CROSSING.format(offset=0.1 * number))
    (folder / "room.yaml").write_text(ROOM)
    (folder / "room.obj").write_text(MESH)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A working directory with the scenes in `scenes/`."""
    write_scenes(tmp_path / "scenes")
    return tmp_path


@dataclass
class Golden:
    """A batch of all scenes that nothing disturbed."""

    place: Path
    contents: Mapping[str, bytes]

    def copy(self, to: Path) -> Path:
        """Its folder once more, as `results` in `to`."""
        return shutil.copytree(self.place / "results", to / "results")


@pytest.fixture(scope="session")
def golden(tmp_path_factory: pytest.TempPathFactory) -> Golden:
    place = tmp_path_factory.mktemp("golden")
    write_scenes(place / "scenes")
    ended = stplan("batch", "scenes", "-o", "results", "--jobs", 2, cwd=place)
    assert ended.status == 0, ended.err
    return Golden(place, lasting(place / "results"))


def lasting(folder: Path) -> dict[str, bytes]:
    """Every file below `folder` that is the same however a batch went, by its path.

    Of run.json and the summaries only what tells no times.
    """
    contents = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            clean = _TIMELESS.get(path.name, lambda content: content)
            contents[str(path.relative_to(folder))] = clean(path.read_bytes())
    return contents


def _timeless_csv(content: bytes) -> bytes:
    rows = list(csv.DictReader(io.StringIO(content.decode())))
    return json.dumps(
        [{key: cell for key, cell in row.items() if "seconds" not in key} for row in rows]
    ).encode()


def _timeless_json(content: bytes) -> bytes:
    whole = json.loads(content)
    for entry in whole["runs"]:
        del entry["seconds"]
    return json.dumps(whole).encode()


def _manifest_only(content: bytes) -> bytes:
    return json.dumps(json.loads(content)["sha256"]).encode()


_TIMELESS: dict[str, Callable[[bytes], bytes]] = {
    "batch.csv": _timeless_csv,
    "batch.json": _timeless_json,
    "run.json": _manifest_only,
}


def assert_nothing_torn(folder: Path) -> None:
    """Every run's folder is whole or was not begun to be written."""
    for path in folder.iterdir():
        if path.is_dir():
            names = {file.name for file in path.iterdir()}
            assert names == RUN_FILES or not names, (path, names)
            assert not names or why_incomplete(path) == ""
    assert not list(folder.glob(".*.tmp"))
