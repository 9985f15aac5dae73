"""What machines and people do to a batch at work: done for real, never acted.

Afterwards every file is whole, what was finished is kept, the words are clear, and the same command
ends with the files of a batch that nothing disturbed.
"""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from stplan.files.atomic import write_set
from stplan.files.json_file import json_bytes
from stplan.files.manifest import manifest, why_incomplete
from tests.batch.conftest import (
    COMMAND,
    ENDLESS,
    Ended,
    assert_nothing_torn,
    lasting,
    stplan,
)

BATCH = ("batch", "scenes", "-o", "results")


@contextmanager
def at_work(place: Path, *arguments: object, **options) -> Iterator[subprocess.Popen[str]]:
    """A batch that runs beside the test, killed at its end with all it started."""
    process = subprocess.Popen(
        [*COMMAND, *map(str, arguments)],
        cwd=place, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options,
    )  # fmt: skip
    with process:
        try:
            yield process
        finally:
            process.kill()


def wait_for(process: subprocess.Popen[str], words: str) -> None:
    """Until a line on stderr holds `words`."""
    assert process.stderr is not None
    read = ""
    for line in process.stderr:
        read += line
        if words in line:
            return
    pytest.fail(f"{words!r} was never said:\n{read}")


def ended(process: subprocess.Popen[str]) -> Ended:
    out, err = process.communicate(timeout=3000)
    return Ended(process.returncode, out, err)


def workers_of(process: subprocess.Popen[str], at_least: int = 0) -> list[int]:
    """The processes in which a batch plans, once there are so many.

    A process that was begun a moment ago has no command line yet.
    """
    found: list[int] = []
    for _ in moments("too few workers"):
        pids = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        found = [int(pid) for pid in pids if b"spawn_main" in command_line(int(pid))]
        if len(found) >= at_least:
            break
    return found


def command_line(pid: int) -> bytes:
    """Of a process; nothing where it has ended, whether or not somebody has noticed."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return b""


def moments(failure: str) -> Iterator[None]:
    """Turns of a loop that waits, short naps apart; the test fails when they take far too long."""
    until = time.monotonic() + 600
    while time.monotonic() < until:
        yield
        time.sleep(0.02)
    pytest.fail(failure)


def test_a_full_disk_then_one_that_cannot_be_written_then_room_again(golden, place):
    # A disk of its own for this test, seen by nobody else.
    own = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--mount", "--map-root-user"]
    script = f"""
set -e
mkdir disk && mount -t tmpfs -o size=76k stplan-test disk || {{ echo no mount >&2; exit 99; }}
batch() {{ status=0; "$@" batch scenes -o disk --jobs 1 2> $log || status=$?; echo $status; }}
log=full batch {" ".join(COMMAND)}
cp -a disk full-disk
mount -o remount,ro disk
log=ro batch {" ".join(COMMAND)}
mount -o remount,rw,size=16m disk
log=room batch {" ".join(COMMAND)}
cp -a disk results
"""
    done = subprocess.run(
        [*own, "sh", "-c", script], cwd=place, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"this test needs the right to mount a tmpfs: {done.stderr}"
    assert [line for line in done.stdout.splitlines() if line.isdigit()] == ["2", "2", "0"]
    full, read_only = ((place / name).read_text().splitlines() for name in ("full", "ro"))
    assert full[-1].startswith("cannot write into disk/")
    assert "No space left on device; the batch ends here; what is finished is written" in full[-1]
    assert read_only == ["cannot write into disk: Read-only file system"]
    assert_nothing_torn(place / "full-disk")
    assert (place / "full-disk/one/report.json").exists()
    assert "one: certified" in (place / "room").read_text()
    assert (place / "room").read_text().count("done before") >= 1
    assert lasting(place / "results") == golden.contents


def test_a_mesh_that_vanishes_while_the_batch_runs(golden, place):
    (place / "scenes/a.yaml").write_text((place / "scenes/one.yaml").read_text())
    with at_work(
        place, *BATCH, "--jobs", 1, "-v", "--filter", "a", "--filter", "room", "--filter", "two"
    ) as process:
        wait_for(process, "a: begun")
        (place / "scenes/room.obj").unlink()
        end = ended(process)
    assert end.status == 2
    (line,) = [line for line in end.err.splitlines() if "room.obj" in line]
    assert line.startswith("room: scenes/room.yaml:3:")
    assert_nothing_torn(place / "results")
    assert not (place / "results/room").exists()
    assert "2 certified, 1 refused" in end.out
    assert lasting(place / "results")["two/report.json"] == golden.contents["two/report.json"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_the_runs_at_work_give_their_best(place, number):
    # As from a terminal: Ctrl-C reaches every process of the group.
    with at_work(
        place, *BATCH, "--jobs", 1, "-v", *ENDLESS, "--json", start_new_session=True
    ) as process:
        wait_for(process, "outer 2/")
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        end = ended(process)
    assert end.status == 130
    assert "Traceback" not in end.err
    assert "one: interrupted: these are the best feasible trajectories so far\n" in end.err
    assert [run["state"] for run in end.json["runs"]] == ["interrupted"] + ["not run"] * 3
    assert_nothing_torn(place / "results")
    assert stplan("check", "results/one", cwd=place).status == 0
    assert [path.name for path in (place / "results").iterdir() if path.is_dir()] == ["one"]


def test_a_second_signal_ends_the_batch_at_once(place):
    with at_work(place, *BATCH, "--jobs", 1, "-v") as process:
        wait_for(process, "one: begun")
        (worker,) = workers_of(process, at_least=1)
        os.kill(worker, signal.SIGSTOP)  # It will not answer.
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGINT)
        end = ended(process)
        assert not Path(f"/proc/{worker}").exists()
    assert end.status == 130
    assert "one: interrupted before there was a result" in end.err
    assert_nothing_torn(place / "results")


@pytest.mark.parametrize(
    "phase", ["prepare", "best_seeds", "optimise_whole", "certify", "plan_files", "replace"]
)
def test_interrupted_in_any_phase_solve_leaves_whole_files_or_none(place, run, monkeypatch, phase):
    """A real Ctrl-C, sent at the door of the phase."""
    from stplan import planned, planner

    where = {"replace": os, "plan_files": planned}.get(phase, planner)
    real = getattr(where, phase)

    def entered(*arguments, **options):
        monkeypatch.setattr(where, phase, real)
        os.kill(os.getpid(), signal.SIGINT)
        return real(*arguments, **options)

    monkeypatch.setattr(where, phase, entered)
    monkeypatch.chdir(place)
    # Shells have what they run in the background ignore Ctrl-C, these tests perhaps.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        result = run("solve", "scenes/room.yaml", "-o", "results")
    finally:
        signal.signal(signal.SIGINT, before)
    assert result.status == 130
    folder = place / "results/room"
    if phase in ("optimise_whole", "plan_files", "replace"):
        assert why_incomplete(folder) == ""
        words = (
            "best feasible"
            if phase == "optimise_whole"
            else "interrupted when its files were written"
        )
        assert words in result.err
        assert run("check", folder).status == 0
    else:
        assert "interrupted before there was a result; nothing was written" in result.err
        assert not folder.exists()


def test_a_worker_that_is_killed_costs_one_attempt(golden, place):
    with at_work(place, *BATCH, "--jobs", 2, "-v") as process:
        wait_for(process, "one: begun")
        for worker in workers_of(process, at_least=1):
            os.kill(worker, signal.SIGKILL)
        end = ended(process)
    assert end.status == 0, end.err
    assert "its worker was killed by SIGKILL" in end.err
    assert lasting(place / "results") == golden.contents


def test_a_worker_killed_once_too_often_is_one_failed_run(golden, place):
    with at_work(place, *BATCH, "--jobs", 1, "-v", "--retries", 0) as process:
        wait_for(process, "one: begun")
        (worker,) = workers_of(process, at_least=1)
        os.kill(worker, signal.SIGKILL)
        end = ended(process)
    assert end.status == 4
    assert "one: its worker was killed by SIGKILL, as systems do when memory runs out" in end.err
    assert "4 runs: 3 certified, 1 died" in end.out
    assert_nothing_torn(place / "results")
    assert not (place / "results/one").exists()


def _small_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (800 * 2**20, 800 * 2**20))


def test_a_limit_of_memory_stops_the_runs_that_need_more(golden, place):
    scene = (place / "scenes/one.yaml").read_text()
    (place / "scenes/huge.yaml").write_text(scene + "solver: {knots: 10000}\n")
    names = ("huge", "one")
    with at_work(
        place, *BATCH, "--jobs", 1, *(f"--filter={name}" for name in names),
        preexec_fn=_small_memory, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    ) as process:  # fmt: skip
        end = ended(process)
    assert end.status == 4
    assert "huge: out of memory: nothing was written" in end.err
    assert "Traceback" not in end.err
    assert "1 certified, 1 out of memory" in end.out
    assert not (place / "results/huge").exists()
    assert lasting(place / "results")["one/report.json"] == golden.contents["one/report.json"]


def test_killed_at_random_moments_and_taken_up_again(golden, place):
    chance = random.Random(20)
    for _ in range(3):
        with at_work(place, *BATCH, "--jobs", 2) as process:
            assert process.stderr is not None
            # Half of them start late: from the first run that is over.
            if chance.random() < 0.7:
                process.stderr.readline()
                time.sleep(chance.uniform(0.0, 0.3))
            else:
                time.sleep(chance.uniform(0.5, 3.0))
            workers = workers_of(process)
            process.kill()
            process.wait()
        for worker in workers:
            _await_end(worker)
    end = stplan(*BATCH, "--jobs", 2, cwd=place)
    assert end.status == 0, end.err
    assert lasting(place / "results") == golden.contents


def _await_end(pid: int) -> None:
    """Workers follow the batch that was killed: nobody plans for nobody."""
    for _ in moments("a worker outlives its batch"):
        if not command_line(pid):
            return


@pytest.mark.parametrize("renamed", range(3))
def test_killed_between_two_renames_the_seal_is_broken(tmp_path, renamed):
    """The old run is whole, then the process dies after `renamed` files of the new one."""
    folder = tmp_path / "run"

    def files(text: bytes) -> dict[str, bytes]:
        contents = {"a.csv": text, "report.json": text}
        return contents | {"run.json": json_bytes({"sha256": manifest(contents)})}

    write_set(folder, files(b"old"))
    assert why_incomplete(folder) == ""
    child = os.fork()
    if child == 0:
        real, calls = os.replace, iter(range(9))

        def replace(source, target):
            if next(calls) == renamed:
                os.kill(os.getpid(), signal.SIGKILL)
            real(source, target)

        os.replace = replace
        write_set(folder, files(b"new"))
        os._exit(0)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == signal.SIGKILL
    assert bool(why_incomplete(folder)) == (renamed > 0)
    assert {path.read_bytes() for path in folder.glob("*.csv")} <= {b"old", b"new"}


def test_two_batches_on_one_folder(place):
    with at_work(place, *BATCH, "--jobs", 1, "-v", *ENDLESS) as first:
        wait_for(first, "one: begun")
        second = stplan(*BATCH, cwd=place)
        assert second.status == 2
        assert second.err.startswith("another batch is at work in results; wait for its end")
        first.kill()
        first.wait()
    # The system frees the lock of a batch that was killed.
    third = stplan(*BATCH, "--filter", "two", "--jobs", 1, cwd=place)
    assert third.status == 0, third.err
    shutil.rmtree(place / "results")
