"""The rival: what it plans, and how both are compared."""

from __future__ import annotations

import csv
import sys
from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import rival
from stplan.bench.rival_table import csv_text, markdown_text
from stplan.certify.certificate import certify
from stplan.cli.app import main

CLEAR = rival.RivalAttempt(0.1, 6.0, 40, "Solve_Succeeded", 1.05, 0.02, True)
CLOSE = replace(CLEAR, padding=0.0, seconds=5.0, clearance=-0.03, certified=False)
DUEL = rival.Duel(16, 0, 1.5, 1.0521, 0.05, True, CLEAR, CLOSE)


def test_the_rival_keeps_discs_apart_at_the_times_of_its_grid():
    scene = rival.field(8, 0)
    lines, stats = rival.rival_plan(scene, 0.0, 20.0)
    assert stats["return_status"] == "Solve_Succeeded"
    curves = np.array(list(lines.curves()))
    assert (curves[:, :, 2] == curves[0, :, 2]).all()
    places = curves[:, 1:-1, :2]
    gaps = np.linalg.norm(places[:, None] - places[None], axis=-1) + 10.0 * np.eye(8)[:, :, None]
    assert gaps.min() == pytest.approx(1.0, abs=1e-4)
    # Between those times they meet: what its distances are enlarged for.
    violations = certify(scene, None, lines).violations
    assert violations
    assert all("more than 1 m is needed" in sentence for sentence in violations)


def test_a_duel_enlarges_distances_until_the_result_is_clear():
    one = rival.duel(rival.field(8, 0), 0, 20.0)
    assert one.certified
    assert one.rival.certified
    assert one.rival.padding > one.unpadded.padding == 0.0
    assert one.unpadded.clearance < 0.0 < one.rival.clearance
    assert one.faster == pytest.approx(one.rival.seconds / one.seconds)
    assert 0.95 < one.dearer < 1.05


def test_who_runs_out_of_time_is_not_tried_again(monkeypatch):
    late = replace(CLOSE, seconds=30.0)
    monkeypatch.setattr(
        rival, "attempt", lambda scene, padding, limit: replace(late, padding=padding)
    )
    one = rival.duel(rival.field(4, 0), 0, 20.0)
    assert one.rival == one.unpadded == late
    assert np.isnan(one.dearer)
    text = markdown_text([replace(one, agents=16, seconds=1.5), DUEL])
    assert "> 18.00" in text
    assert "nan" not in csv_text([one])


def test_cells_of_a_duel():
    cells = [cell.strip() for cell in markdown_text([DUEL]).splitlines()[2].split("|")[1:-1]]
    assert cells == [
        "16", "1.50", "6.00", "4.0", "3", "1.0020", "1.01", "50", "20", "10", "-30",
    ]  # fmt: skip


def test_the_command_says_what_is_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(SystemExit) as left:
        main(["bench", "rival", "-o", str(tmp_path)])
    assert left.value.code == 2
    assert "pip install 'stplan[rivals]'" in capsys.readouterr().err


def test_the_command_writes_duels_a_table_and_a_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(rival, "SMALL_SIZES", (4, 8))
    monkeypatch.setattr(
        rival, "duel", lambda scene, draw, limit: replace(DUEL, agents=len(scene.agents))
    )
    with pytest.raises(SystemExit) as left:
        main(["bench", "rival", "-o", str(tmp_path)])
    assert left.value.code == 0
    assert (tmp_path / "rival.md").read_text() == capsys.readouterr().out
    assert (tmp_path / "rival.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "rival.csv").open() as stream:
        assert [row["agents"] for row in csv.DictReader(stream)] == ["4", "8"]
