"""Crowds planned whole: the families, the table, the command."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stplan.bench import crowds
from stplan.bench.crowds_table import csv_text, markdown_text
from stplan.bench.families_crowds import FAMILIES
from stplan.cli.app import main
from stplan.errors import UsageError

DRAW = crowds.CrowdSolve(
    family="grid room", agents=40, draw=0, seconds=5.0, asked=10.0, found_by="search (emptying)",
    certified=True, length_over_least=np.nan,
)  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES)
def test_families_make_scenes_of_their_size_from_a_seed(family: str) -> None:
    scene = FAMILIES[family](20, 3)
    assert scene.content_hash == FAMILIES[family](20, 3).content_hash
    if family == "stream":
        assert 8 <= len(scene.agents) <= 35
    else:
        assert len(scene.agents) == 20
    if family != "grid room":
        assert [a.start for a in scene.agents] != [a.start for a in FAMILIES[family](20, 4).agents]


def test_families_are_chosen_by_name() -> None:
    assert {case[0] for case in crowds.chosen_cases(["grid", "ex"], full=False)} == {
        "grid room", "exchange",
    }  # fmt: skip
    assert crowds.chosen_cases([], full=False) == crowds.SMALL_CASES
    with pytest.raises(UsageError, match="no family 'door'"):
        crowds.chosen_cases(["door"], full=True)


def test_the_table_counts_certified_plans() -> None:
    late = replace(DRAW, draw=1, seconds=12.0)
    lost = replace(DRAW, draw=2, seconds=60.0, certified=False, found_by="")
    text = markdown_text([DRAW, late, lost])
    (row,) = [line for line in text.splitlines() if line.startswith("| grid room")]
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert cells[1:7] == ["40", "2 of 3", "12.0", "60.0", "10", "-"]
    assert cells[7] == "none; search (emptying)"
    assert csv_text([DRAW]).splitlines()[0].startswith("family,agents,draw,seconds,asked")


def test_the_command_measures_what_is_small_enough(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crowds, "SMALL_CASES", (("assigned", 12, 9.0), ("grid room", 40, 9.0)))
    with pytest.raises(SystemExit) as left:
        main(["bench", "crowds", "--draws", "1", "--largest", "12", "-o", str(tmp_path)])
    assert not left.value.code
    (row,) = [line for line in capsys.readouterr().out.splitlines() if "assigned" in line]
    assert "1 of 1" in row
    assert float(row.split("|")[7]) < 1.01
    assert (tmp_path / "crowds.csv").read_text().count("\n") == 2
