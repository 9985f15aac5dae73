"""The figures the planner is held to: cases, verdicts, files."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import figures
from stplan.bench.figures_table import asked_table, csv_text, markdown_text
from stplan.bench.solves import SolveFigures
from stplan.cli.app import main
from stplan.errors import UsageError
from stplan.world import build_free_space, check_scene_in_world

CASES = {case.name: case for case in figures.cases()}
GOOD = SolveFigures(
    agents=8, knots=248, found_by="relaxation", status="converged", certified=True,
    seed_seconds=0.1, optimise_seconds=0.5, total_seconds=0.75, iterations=25,
    evaluation_share=0.125, kinetic_seed=1.01, kinetic_end=1.0025, clearance=0.01, peak_mib=200.0,
)  # fmt: skip


def figure(name, run=GOOD, **changes):
    return replace(figures.Figure(name, CASES[name].title, run, None), **changes)


@pytest.mark.parametrize(
    "name", [name for name in CASES if name not in ("flows-512", "field-1000")]
)
def test_cases_are_valid_scenes(name):
    scene = CASES[name].scene()
    assert check_scene_in_world(scene, build_free_space(scene)) == []


def test_names_and_their_beginnings_choose_cases():
    small, full = (figures.chosen_cases([""], full=full) for full in (False, True))
    assert [one.name for one in full] == list(CASES)
    assert 0 < len(small) < len(full)
    chosen = figures.chosen_cases(["circle", " flows-512"], full=False)
    assert [one.name for one in chosen] == ["circle-8", "circle-20", "circle-35", "flows-512"]
    with pytest.raises(UsageError, match="no figure 'circ'; expected some of circle-8"):
        figures.chosen_cases(["circ"], full=False)


def test_what_is_asked_stands_beside_what_is_measured():
    late = figure("circle-20", replace(GOOD, total_seconds=4.0, certified=False))
    text = asked_table([CASES["circle-8"], CASES["circle-20"]], [figure("circle-8"), late])
    cells = [[cell.strip() for cell in line.split("|")[2:-1]] for line in text.splitlines()[2:]]
    assert cells == [
        ["certified", "yes", "yes", "yes"],
        ["total seconds", "1.50", "0.75", "yes"],
        ["kinetic over straight", "1.0030", "1.0025", "yes"],
        ["certified", "yes", "no", "no"],
        ["total seconds", "3.00", "4.00", "no, 1.00 too much"],
        ["kinetic over straight", "1.0080", "1.0025", "yes"],
    ]


def test_a_tight_scene_is_held_to_its_converged_cost():
    door = figure("door", over_converged=0.035, converged_seconds=40.0)
    assert "no, 0.015 too much" in asked_table([CASES["door"]], [door])
    assert "after 5 s 3.5 % above its cost after 40 s" in figures.outcome(door)


def test_a_scene_without_a_plan_reaches_nothing():
    failed = figure("circle-8", SolveFigures(8, status="failed: too tight", total_seconds=1.0))
    assert figures.outcome(failed) == "failed: too tight"
    text = markdown_text([CASES["circle-8"]], [failed])
    assert "nan" not in text
    row = next(csv.DictReader(csv_text([failed]).splitlines()))
    assert (row["status"], row["certified"], row["kinetic_end"]) == ("failed: too tight", "0", "")


def test_the_command_measures_and_writes(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["bench", "figures", "-o", str(tmp_path), "--only", "small-circle-8"])
    assert left.value.code == 0
    out, err = capsys.readouterr()
    assert (tmp_path / "figures.md").read_text() == out
    assert "small-circle-8: seed" in err
    with (tmp_path / "figures.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["figure"] for row in rows] == ["small-circle-8"]
    assert rows[0]["certified"] == "1"
    assert rows[0]["conflicts"] == "28"
    assert 1.0 <= float(rows[0]["kinetic_end"]) <= float(rows[0]["kinetic_seed"])
    assert 0.0 < float(rows[0]["evaluation_share"]) < 1.0
    assert float(rows[0]["seed_seconds"]) < float(rows[0]["total_seconds"])


def test_a_cost_after_some_seconds_is_at_best_the_converged_one():
    scene = CASES["small-circle-8"].scene()
    measured, planned = figures.run(scene)
    assert planned is not None
    compared = figures._compared(figure("small-circle-8", measured), planned)
    assert compared.over_converged >= 0.0
    assert np.isfinite(compared.converged_seconds)
