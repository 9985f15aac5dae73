"""The measurement of the seeder: its families, what it counts, and the files it writes."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from stplan.bench import seeding
from stplan.bench.seeding_table import csv_text, markdown_text
from stplan.cli.app import main
from stplan.errors import SeedingError, UsageError
from stplan.world import build_free_space, check_scene_in_world

FAMILIES = {family.name: family for family in seeding.families()}
PLAIN = seeding.Measurement("door 3 a side", 0, 6, True, 2.0, 1.5, 1.25, "relaxation", "")


@pytest.mark.parametrize("name", [name for name in FAMILIES if not name.endswith("00")])
def test_draws_are_repeatable_valid_and_differ(name):
    first, again = (seeding.draw_scene(FAMILIES[name], 0) for _ in range(2))
    other = seeding.draw_scene(FAMILIES[name], 1)
    # Only the maps and the agents are drawn.
    assert (first.map, first.agents) == (again.map, again.agents)
    assert (first.map, first.agents) != (other.map, other.agents)
    assert check_scene_in_world(first, build_free_space(first)) == []
    for ends in ([one.start for one in first.agents], [one.goal for one in first.agents]):
        gaps = np.linalg.norm(np.subtract(np.array(ends)[:, None], ends), axis=2)
        np.fill_diagonal(gaps, np.inf)
        assert gaps.min() > 2.0 * max(one.radius for one in first.agents)


def test_two_of_the_lanes_are_heavy():
    scene = seeding.draw_scene(FAMILIES["lanes 102, 2 heavy"], 0)
    assert len(scene.agents) == 102
    assert sum(one.mass > 1.0 for one in scene.agents) == 2


def test_names_kinds_and_sizes_choose_families():
    small, full = (seeding.chosen_families([], full=full) for full in (False, True))
    assert len({one.name for one in full}) == len(full) > len(small)
    assert [one.name for one in seeding.chosen_families(["cabin"], full=False)] == [
        "cabin one deep"
    ]
    assert [one.name for one in seeding.chosen_families(["cabin two deep"], full=False)] == [
        "cabin two deep"
    ]
    with pytest.raises(UsageError, match="no family 'cab'; expected one of corridor, plus"):
        seeding.chosen_families(["cab"], full=True)


def test_the_command_writes_a_row_a_draw_and_a_row_a_family(tmp_path, capsys):
    folder = tmp_path / "new"
    with pytest.raises(SystemExit) as left:
        main(["bench", "seeding", "-o", str(folder), "--draws", "1",
              "--families", "corridor 3 r,open field 0.06 25"])  # fmt: skip
    assert left.value.code == 0
    out, err = capsys.readouterr()
    assert (folder / "seeding.md").read_text() == out
    assert [line.split("|")[1].strip() for line in out.splitlines()[2:]] == [
        "corridor 3 r",
        "open field 0.06 25",
    ]
    with (folder / "seeding.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["family"], row["agents"], row["success"]) for row in rows] == [
        ("corridor 3 r", "2", "1"),
        ("open field 0.06 25", "25", "1"),
    ]
    assert all(float(row["seconds"]) > 0 for row in rows)
    assert all(float(row["kinetic_over_straight"]) >= 1.0 for row in rows)
    assert "warm-up" in err
    assert "draw 1 of 1" in err


def test_an_unknown_family_is_a_usage_error(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["bench", "seeding", "-o", str(tmp_path), "--families", "nothing"])
    assert left.value.code == 2
    assert "there is no family 'nothing'" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_draw_without_a_seed_is_a_failure(monkeypatch):
    def fail(*arguments, **named):
        raise SeedingError("no collision-free initial curves: too tight\n  and more")

    monkeypatch.setattr(seeding, "find_seed", fail)
    one = seeding.measure_one(FAMILIES["corridor 3 r"], 0, 1.0)
    assert not one.success
    assert one.reason == "no collision-free initial curves: too tight"
    assert one.found_by == ""


def test_a_seed_that_does_not_hold_its_certificate_is_a_failure(monkeypatch):
    find = seeding.find_seed

    def shifted(problem, *, progress):
        seed = find(problem, progress=progress)
        return replace(seed, world_lines=seed.world_lines.with_knots(seed.world_lines.knots + 1e-3))

    monkeypatch.setattr(seeding, "find_seed", shifted)
    one = seeding.measure_one(FAMILIES["corridor 3 r"], 0, 5.0)
    assert not one.success
    assert "starts at" in one.reason


def test_failures_count_in_the_times_but_not_in_the_ratio():
    failed = replace(
        PLAIN, draw=1, success=False, seconds=6.0, kinetic_over_straight=np.nan, found_by=""
    )
    cells = markdown_text([PLAIN, failed]).splitlines()[2].split("|")[1:-1]
    assert [cell.strip() for cell in cells] == [
        "door 3 a side", "2", "50", "4.000", "6.000", "1.500", "1.250", "relaxation 1",
    ]  # fmt: skip
    assert csv_text([failed]).splitlines()[1] == "door 3 a side,1,6,0,6,1.5,,,"


def test_the_growth_is_fitted_to_the_open_field():
    field = [
        replace(PLAIN, family=f"open field 0.06 {size}", agents=size, seconds=1e-5 * size**1.5)
        for size in (100, 500, 1000)
    ]
    assert seeding.growth_exponent(field) == pytest.approx(1.5)
    assert "agents^1.50" in markdown_text(field)
    assert seeding.growth_exponent([*field[:1], PLAIN]) is None
