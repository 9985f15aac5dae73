"""Hundreds of malformed scenes: each is refused with its place, soon, and leaves nothing behind."""

from __future__ import annotations

import re
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from stplan.cli.app import main
from tests.refusals import damages, foreign, hopeless, meshes, mutations
from tests.refusals.case import BASES, Case, base, beside, dump
from tests.refusals.meshes import content_of

# A third of it is what a user waits at most; a busy machine takes longer for the same work.
SECONDS = 15
MEMORY = 2**30
CORPUS = [
    *mutations.cases(), *damages.cases(), *meshes.cases(), *foreign.cases(), *hopeless.cases()
]  # fmt: skip
PLACED = re.compile(r"scene\.yaml:[1-9]\d*:[1-9]\d*: ")


@pytest.fixture
def bounded() -> Iterator[None]:
    """Little more memory than there is in use, and a hang is interrupted."""

    def late(*arguments: object) -> None:
        raise TimeoutError(f"more than {SECONDS} s of work")

    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    in_use = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    handler = signal.signal(signal.SIGPROF, late)
    resource.setrlimit(resource.RLIMIT_AS, (in_use + MEMORY, hard))
    # Of work, not of waiting: other programs may be busy.
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    yield
    signal.setitimer(signal.ITIMER_PROF, 0)
    signal.signal(signal.SIGPROF, handler)
    resource.setrlimit(resource.RLIMIT_AS, (before, hard))


def written(folder: Path, case: Case) -> None:
    (folder / "scene.yaml").write_bytes(case.text)
    for name, content in case.files.items():
        (folder / name).write_bytes(content_of(content))


def tree(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def judge(case: Case, status: int, err: str) -> None:
    assert status == case.status, err
    assert "Traceback" not in err
    assert "internal error" not in err
    assert len(err) < 2_000_000
    if status == 3:
        assert case.path in err
        return
    faults = err.splitlines()
    assert faults
    assert all(PLACED.match(fault) for fault in faults), err[:500]
    assert any(case.path in PLACED.sub("", fault) for fault in faults), err[:500]


def test_the_corpus_is_large_and_every_case_another() -> None:
    assert len({(case.text, tuple(map(str, case.files))) for case in CORPUS}) >= 600
    assert len({case.name for case in CORPUS}) == len(CORPUS)


@pytest.mark.parametrize("name", BASES)
def test_what_mutations_start_from_is_valid(name, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path, Case(name, dump(base(name)), beside(name)))
    with pytest.raises(SystemExit) as left:
        main(["validate", "scene.yaml"])
    assert left.value.code == 0, capsys.readouterr().err


@pytest.mark.parametrize("case", CORPUS, ids=lambda case: case.name)
def test_refused(case: Case, tmp_path, monkeypatch, capsys, bounded) -> None:
    for name in ("here", "temporary"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    written(tmp_path / "here", case)
    before = tree(tmp_path)
    with pytest.raises(SystemExit) as left:
        main(["solve", "scene.yaml", "-o", str(tmp_path / "there"), "--quiet"])
    out, err = capsys.readouterr()
    judge(case, int(left.value.code or 0), err)
    assert out == ""
    assert tree(tmp_path) == before


PROGRAM = """
import resource, sys
import stplan.planner, trimesh, networkx
from stplan.cli.app import main
in_use = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
spent = int(resource.getrusage(resource.RUSAGE_SELF).ru_utime + 1)
resource.setrlimit(resource.RLIMIT_AS, (in_use + {memory},) * 2)
resource.setrlimit(resource.RLIMIT_CPU, (spent + {seconds},) * 2)
main(["solve", "scene.yaml", "-o", "there", "--quiet"])
"""
WORST = [
    "alias bomb at description",
    "ply: 10^7 vertices",
    "svg: uses of uses",
    "picture: zip bomb",
]


@pytest.mark.parametrize("name", WORST)
def test_refused_in_a_process_with_hard_limits(name, tmp_path) -> None:
    (case,) = [case for case in CORPUS if case.name == name]
    written(tmp_path, case)
    before = tree(tmp_path)
    program = PROGRAM.format(memory=MEMORY, seconds=SECONDS)
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    judge(case, done.returncode, done.stderr)
    assert tree(tmp_path) == before
