"""The variants of the optimiser: when a trace counts as near the best, and what is written."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from stplan.bench import convergence
from stplan.bench.convergence import Trace, outcomes
from stplan.bench.convergence_table import csv_text, markdown_text
from stplan.cli.app import main
from stplan.errors import UsageError

SCENE = Path(__file__).parents[2] / "scenes" / "three-agents" / "symmetric.yaml"


def trace(variant, costs, certified=True):
    seconds = 0.5 * np.arange(len(costs))
    return Trace("scene", variant, np.array(costs), seconds, 0.01, certified, "converged")


def test_near_is_where_a_trace_comes_to_stay():
    best, late, poor = outcomes(
        [
            trace("best", [200.0, 100.5, 100.05, 100.0]),
            # Cheap at first, because it starts with hardly any clearance.
            trace("late", [100.5, 150.0, 101.5, 100.9]),
            trace("poor", [200.0, 180.0]),
        ]
    )
    assert best.iterations_near == (1.0, 2.0)
    assert best.seconds_near == (0.5, 1.0)
    assert best.over_best == 0.0
    assert late.iterations_near[0] == 3.0
    assert np.isnan(late.iterations_near[1])
    assert late.over_best == pytest.approx(0.009)
    assert [one.failed for one in (best, late, poor)] == [False, False, True]


def test_costs_without_a_certificate_are_no_best_ones():
    broken, sound = outcomes([trace("broken", [50.0], certified=False), trace("sound", [100.0])])
    assert sound.over_best == 0.0
    assert broken.failed
    assert not sound.failed


def test_medians_count_what_was_never_reached_as_late():
    found = []
    for name, costs in (("a", [100.0]), ("b", [200.0]), ("c", [200.0])):
        found += outcomes([trace("one", costs), trace("other", [100.0 + len(name)])])
    row = next(line for line in markdown_text(found).splitlines() if line.startswith("| one"))
    assert [cell.strip() for cell in row.split("|")[2:6]] == ["3", "2", "1", "-"]


def test_the_command_measures_the_scenes_and_variants_named(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["bench", "convergence", str(SCENE), "-o", str(tmp_path),
              "--variants", "default,mu of the paper"])  # fmt: skip
    assert left.value.code == 0
    out = capsys.readouterr().out
    assert (tmp_path / "convergence.md").read_text() == out
    assert (tmp_path / "convergence.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "convergence.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["variant"] for row in rows] == ["default", "mu of the paper"]
    assert all(row["certified"] == "1" for row in rows)
    assert min(float(row["over_best"]) for row in rows) == 0.0
    assert float(rows[1]["over_best"]) > 0.0
    assert float(rows[1]["clearance"]) > float(rows[0]["clearance"]) > 0.0
    assert csv_text([]) == ""


def test_scenes_are_found_or_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(Path(__file__).parents[2])
    small, full = (convergence.shipped_scenes([], full=full) for full in (False, True))
    assert {path.stem for path in small} == set(convergence.SMALL_SCENES)
    assert set(small) < set(full)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match="name some"):
        convergence.shipped_scenes([], full=True)
    assert convergence.shipped_scenes([SCENE], full=True) == [SCENE]
    with pytest.raises(UsageError, match="no variant 'fast'; expected some of default"):
        convergence.chosen_variants(["fast"])
