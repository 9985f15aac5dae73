"""Whole commands beside a yardstick."""

from __future__ import annotations

import csv
from contextlib import nullcontext

import pytest

from stplan.bench import startup
from stplan.bench.startup import FIRST, YARDSTICK_NAME, Spent, Timed
from stplan.cli.app import main
from stplan.errors import UsageError

SCENE = """\
stplan: 1
horizon: 6.0
agents: [{id: sam, start: [-2.0, 0.0], goal: [2.0, 0.1]}]
"""


def test_every_command_is_timed_beside_the_yardstick(tmp_path, monkeypatch, capsys):
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE)
    monkeypatch.setattr(startup, "ROUNDS", 1)
    kept = nullcontext(str(tmp_path / "kept"))
    monkeypatch.setattr(startup.tempfile, "TemporaryDirectory", lambda **options: kept)
    with pytest.raises(SystemExit) as left:
        main(["bench", "startup", "--scene", str(scene), "-o", str(tmp_path / "out")])
    assert left.value.code == 0, capsys.readouterr().err
    rows = list(csv.DictReader((tmp_path / "out/startup.csv").read_text().splitlines()))
    assert [row["command"] for row in rows] == [
        YARDSTICK_NAME, "--help", "validate", "solve", FIRST,
    ]  # fmt: skip
    yardstick, *_, solve, first = rows
    assert (yardstick["wall_share"], yardstick["processor_share"]) == ("1", "1")
    assert int(solve["runs"]) == int(first["runs"]) == 1
    assert list((tmp_path / "kept/kernels-0").rglob("*.nbi")), "nothing was compiled"
    assert "Measured on" in (tmp_path / "out/startup.md").read_text()


def test_shares_are_those_of_medians():
    beside = (Spent(1.0, 0.5), Spent(2.0, 1.0), Spent(9.0, 9.0))
    timed = Timed("solve", (Spent(6.0, 3.0), Spent(3.0, 2.0), Spent(4.0, 9.0)), beside)
    assert (timed.wall, timed.processor) == (4.0, 3.0)
    assert (timed.wall_share, timed.processor_share) == (2.0, 3.0)


def test_what_goes_wrong_is_said(tmp_path):
    missing = tmp_path / "none.yaml"
    with pytest.raises(UsageError, match="there is no"):
        startup.measure(missing, rounds=1, first_rounds=1, progress=print)
    missing.write_text("stplan: 1")
    with pytest.raises(UsageError, match=r"validate .*agents: is missing"):
        startup.measure(missing, rounds=1, first_rounds=1, progress=print)
