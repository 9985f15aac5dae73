"""All benchmarks in one command."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan.cli import bench
from stplan.cli.app import main


def test_all_runs_each_of_them_and_describes_the_machine(tmp_path, monkeypatch, capsys):
    ran = []

    def note(name):
        def run(console, *arguments, output, full):
            ran.append((name, output, full))
            return 0

        return run

    for name in ("startup", "figures", "_sweep", "rival", "seeding", "convergence"):
        monkeypatch.setattr(bench, name, note(name))
    monkeypatch.chdir(Path(__file__).parents[2])
    with pytest.raises(SystemExit) as left:
        main(["bench", "all", "--full", "-o", str(tmp_path)])
    assert left.value.code == 0
    assert {name for name, _, _ in ran} == {
        "startup",
        "figures",
        "_sweep",
        "rival",
        "seeding",
        "convergence",
    }
    assert [name for name, _, _ in ran].count("_sweep") == 3
    assert all((output, full) == (tmp_path, True) for _, output, full in ran)
    machine = (tmp_path / "machine.md").read_text()
    assert capsys.readouterr().out == machine
    assert "cores" in machine
    assert "ipopt 3." in machine


def test_what_is_missing_is_said_before_anything_is_measured(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as left:
        main(["bench", "all", "-o", str(tmp_path / "out")])
    assert left.value.code == 2
    assert "there are no scenes/*/*.yaml here" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
