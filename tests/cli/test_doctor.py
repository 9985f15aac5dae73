"""`stplan doctor` and `stplan --version`: what is installed, and whether it works."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.metadata import version

import pytest

from stplan.cli import doctor
from stplan.installation import trials
from stplan.installation.trials import SelfTest


def test_it_says_what_is_there_and_plans_to_prove_it(run):
    result = run("doctor")
    assert result.status == 0
    for line in ("stplan ", "libraries: numpy ", "kernels: ", "browser: ", "self-test: passed in "):
        assert f"\n{line}" in f"\n{result.out}"
    found = run("doctor", "--json").json
    assert found["exit_status"] == 0
    assert found["versions"]["numpy"] == version("numpy")
    assert 0 < found["kernels"]["compiled"] <= found["kernels"]["kernels"]
    assert found["self_test"]["certified"]
    assert "left_for_later" not in found


def test_a_broken_installation_is_an_exit_status(run, monkeypatch):
    monkeypatch.setattr(trials, "self_test", lambda: SelfTest(False, "certificate IS BROKEN", 0.1))
    result = run("doctor")
    assert result.status == 4
    assert "self-test: FAILED" in result.out


def test_compiling_ahead_shows_how_far_it_is(run, monkeypatch):
    def compile_kernels(progress):
        for done in range(9):
            progress(done, 8)
        return ("stplan.some.kernel",)

    monkeypatch.setattr(trials, "compile_kernels", compile_kernels)
    result = run("doctor", "--compile", "--json")
    assert result.json["left_for_later"] == ["stplan.some.kernel"]
    assert "compiling: 4 of 8 kernels" in result.err
    assert "left for when they are needed: stplan.some.kernel" in result.err


def test_the_bar_fills():
    drawn = []
    progress = doctor._bar(lambda make: drawn.append(make()))
    progress(0, 46)
    progress(46, 46)
    assert [line.count("#") for line in drawn] == [0, 30]
    assert drawn[1].endswith("46 of 46 kernels")


def test_versions_for_programs(run):
    assert run("--version").out == f"stplan {version('stplan')}\n"
    found = run("--version", "--json").json
    assert found["stplan"] == version("stplan")
    assert set(found) >= {"python", "platform", "numpy", "numba", "shapely"}
    assert run("--json", "--version").json == found


@pytest.mark.parametrize("words", [["--json"], ["--json", "validate", "x.yaml"]])
def test_switches_without_a_command_are_refused(run, words):
    result = run(*words)
    assert result.status == 2
    assert result.out == ""


def test_a_cache_that_is_empty_or_cannot_be_written_is_seen(tmp_path):
    program = (
        "from stplan.installation.kernels import kernel_cache; import json, dataclasses;"
        "print(json.dumps(dataclasses.asdict(kernel_cache())))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    found = json.loads(done.stdout)
    assert found["compiled"] == 0
    assert found["kernels"] > 40
    assert found["writable"]
    assert all(folder.startswith(str(tmp_path)) for folder in found["folders"])
