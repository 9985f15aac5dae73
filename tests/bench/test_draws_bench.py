"""Default plans beside the best of all methods, on random draws: the figures, the table, the command."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.bench import draws
from stplan.bench.draws import DrawTrial
from stplan.bench.draws_table import csv_text, markdown_text
from stplan.cli.app import main
from stplan.errors import UsageError
from stplan.multistart import EFFORTS


def trial(family: str, draw: int, default: float, improved: float, other: float) -> DrawTrial:
    costs = {"default": default, "improved": improved, "search": other}
    return DrawTrial(family, draw, 4, costs, seconds=1.0)


NEAR = trial("door", 0, 1.0, 1.0, 2.0)
DEAR = trial("door", 1, 1.03, 1.02, 1.0)
MISSED = trial("cabin", 0, np.nan, np.nan, 3.0)
IMPOSSIBLE = trial("cabin", 1, np.nan, np.nan, np.nan)


def test_the_default_is_measured_by_the_cheapest_of_all():
    assert (NEAR.best, NEAR.excess) == ("default", 0.0)
    assert DEAR.best == "search"
    assert DEAR.excess == pytest.approx(0.03)
    assert MISSED.excess == np.inf
    assert IMPOSSIBLE.best == ""
    assert np.isnan(IMPOSSIBLE.excess)


def test_the_table_has_a_row_a_family_and_one_of_all():
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in markdown_text([NEAR, DEAR, MISSED, IMPOSSIBLE]).splitlines()[2:]
    ]
    assert rows == [
        ["door", "2", "2", "50%", "100%", "1.5", "3.0", "1.0", "search 1"],
        ["cabin", "2", "0", "0%", "0%", "inf", "inf", "1.0", "search 1"],
        ["all", "4", "2", "33%", "67%", "3.0", "inf", "1.0", "search 2"],
    ]


def test_the_csv_has_every_cost():
    head, first, *rest = csv_text([DEAR, IMPOSSIBLE]).splitlines()
    assert head == "family,draw,agents,seconds,best,excess,default,improved,search"
    assert first == "door,1,4,1,search,0.03,1.03,1.02,1"
    assert rest == ["cabin,1,4,1,,,,,"]


def test_draws_are_the_same_every_time_and_leave_the_metric_to_the_program():
    one, again, other = (draws.drawn("door", number) for number in (0, 0, 1))
    assert one == again
    assert one.agents != other.agents
    assert one.metric == "auto"


def test_families_are_chosen_by_name():
    assert draws.chosen([]) == list(draws.DRAWN)
    assert draws.chosen(["cabin"]) == ["cabin one deep", "cabin two deep"]
    with pytest.raises(UsageError, match="no scene 'moon'"):
        draws.chosen(["moon"])


def test_a_draw_is_planned_by_default_and_by_other_methods(monkeypatch):
    monkeypatch.setattr(draws, "warm_up", lambda: None)
    monkeypatch.setitem(EFFORTS, "normal", EFFORTS["quick"])
    methods = {"search": draws.METHODS["search"]}
    (found,) = draws.measure(["plus right"], 1, 1, methods=methods, progress=lambda line: None)
    assert list(found.costs) == ["default", "improved", "search"]
    assert found.agents == 4
    assert 0.0 < found.costs["improved"] <= found.costs["default"]
    assert found.excess >= 0.0


def test_the_command_draws_where_it_is_asked_to(tmp_path, monkeypatch, capsys):
    asked = []

    def measure(families, number, moves, progress):
        asked.append((families, number, moves))
        return [NEAR, DEAR]

    monkeypatch.setattr(draws, "measure", measure)
    with pytest.raises(SystemExit) as left:
        main(["bench", "quality", "--draws", "2", "--only", "door", "-o", str(tmp_path)])
    assert not left.value.code
    assert asked == [(["door"], 2, 20)]
    assert {path.name for path in tmp_path.iterdir()} == {"draws.csv", "draws.md"}
    assert "search 1" in capsys.readouterr().out
