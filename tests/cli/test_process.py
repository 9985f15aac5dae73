"""What only a process of its own can show: signals, pipes, encodings."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-m", "stplan"]


def _run(*arguments: object, **options):
    return subprocess.run(
        [*COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False,
        timeout=60, **options,
    )  # fmt: skip


def test_version():
    result = _run("--version")
    assert (result.returncode, result.stdout) == (0, f"stplan {metadata.version('stplan')}\n")


SCENE = """\
stplan: 1
horizon: 9.0
agents: [{id: sam, start: [0.0, 0.0], goal: [5.0, 5.0]}]
"""
# A command whose planning is `action` instead.
WAITING = """
import sys, time
from stplan import planner
def plan(scene, *, progress, live, stop, **others):
    progress("planning")
    {action}
planner.plan = plan
from stplan.cli.app import main
main(["solve", "scene.yaml", *sys.argv[1:]])
"""


def _start(tmp_path, action="time.sleep(60)", **options):
    (tmp_path / "scene.yaml").write_text(SCENE)
    return subprocess.Popen(
        [sys.executable, "-c", WAITING.format(action=action)],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, text=True,
        stderr=subprocess.PIPE, **({"stdout": subprocess.PIPE} | options),
    )  # fmt: skip


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_with_130_and_no_traceback(tmp_path, number):
    with _start(tmp_path) as process:
        assert process.stderr is not None
        assert process.stderr.readline() == "planning\n"
        process.send_signal(number)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out == ""
    assert err == "interrupted before there was a result; nothing was written\n"
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]


def test_a_reader_of_progress_that_goes_away_stops_nothing(tmp_path):
    action = """
    time.sleep(0.5)
    progress("more")
    open("done", "w").close()
    raise KeyboardInterrupt"""
    with _start(tmp_path, action) as process:
        assert process.stderr is not None
        process.stderr.readline()
        process.stderr.close()
        assert process.stdout is not None
        process.stdout.close()
        assert process.wait(timeout=30) == 130
    assert (tmp_path / "done").exists()


def test_stdout_on_a_full_disk(tmp_path):
    (tmp_path / "t.csv").write_text("agent,knot,x,y,t\na,0,0,0,0\na,1,1,1,1\n")
    for options in ([], ["--json"]):
        with Path("/dev/full").open("w") as full:
            result = subprocess.run(
                [*COMMAND, "diff", "t.csv", "t.csv", *options],
                cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            )  # fmt: skip
        assert result.returncode == 2
        assert result.stderr == "cannot write to standard output: No space left on device\n"


def test_a_closed_stdout_and_a_poor_encoding(tmp_path):
    (tmp_path / "t.csv").write_text("agent,knot,x,y,t\né,0,0,0,0\né,1,1,1,1\n", encoding="utf-8")
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    result = _run("diff", "t.csv", "t.csv", "-v", cwd=tmp_path, env=environment)
    assert result.returncode == 0, result.stderr
    assert "\\xe9: position 0 m" in result.stdout
    closed = subprocess.run(
        ["sh", "-c", f"{sys.executable} -m stplan diff t.csv t.csv >&-"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (closed.returncode, closed.stderr) == (0, "")


def test_json_of_a_process_is_parseable(tmp_path):
    result = _run("solve", "none.yaml", "--json", cwd=tmp_path)
    assert result.returncode == 2
    assert json.loads(result.stdout)["exit_status"] == 2
