"""What the metric does to whole plans: the scenes, the trials, the tables, the command."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stplan import load_scene
from stplan.bench import metric
from stplan.bench.metric import MetricTrial, chosen, in_metric
from stplan.bench.metric_table import csv_text, markdown_text
from stplan.cli.app import main
from stplan.errors import UsageError

ROOT = Path(__file__).parents[2]
TRIALS = [
    MetricTrial("door", 6, 1.0, 2.0, 40, 1.5),
    MetricTrial("door", 6, "auto", 1.6, 50, 2.5),
    MetricTrial("lane", 2, 1.0, np.nan, 0, 0.5),
    MetricTrial("lane", 2, "auto", 1.0, 30, 0.25),
]


def stplan(*arguments: object) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    return int(left.value.code or 0)


def test_scenes_are_shipped_or_generated_and_leave_the_metric_open():
    small = chosen(ROOT / "scenes", [], full=False)
    assert set(metric.SMALL_SCENES) < set(small)
    assert all(scene.metric == "auto" for scene in small.values())
    assert list(chosen(ROOT / "scenes", ["gap", "of 10"], full=False)) == [
        "comparison/gap",
        "cabin of 10",
    ]
    with pytest.raises(UsageError, match="no scene 'moon'"):
        chosen(ROOT / "scenes", ["moon"], full=True)


def test_c_is_stated_or_left_open():
    scene = load_scene(ROOT / "scenes/tight/cabin.yaml")
    stated = in_metric(scene, 3.0)
    assert (stated.metric, stated.time_scale) == ("stated", 3.0)
    assert in_metric(stated, "auto").metric == "auto"


def test_the_tables_compare_with_the_cheapest_and_count_what_was_planned():
    lines = markdown_text(TRIALS).splitlines()
    assert [cell.strip() for cell in lines[2].split("|")[1:-1]] == [
        "1.0", "1 of 2", "25.0", "25.0", "25.0", "40", "2.0",
    ]  # fmt: skip
    assert "2 of 2" in lines[3]
    assert "2 (1.5)" in lines[7]
    assert "none (0.5)" in lines[8]
    assert csv_text(TRIALS).splitlines()[3].startswith("lane,2,1,0,,0")


def test_a_scene_without_a_plan_counts_as_not_planned(monkeypatch):
    monkeypatch.setattr(metric, "warm_up", lambda: None)
    scene = in_metric(load_scene(ROOT / "scenes/tight/pocket-swap.yaml"), "auto")
    hopeless = replace(scene, seeding=replace(scene.seeding, time_limit=1e-9))
    (found,) = metric.measure(
        {"pocket": hopeless}, time_scales=["auto"], progress=lambda line: None
    )
    assert not found.found
    assert found.iterations == 0


def test_a_scene_is_tried_in_every_metric(monkeypatch):
    monkeypatch.setattr(metric, "warm_up", lambda: None)
    scene = load_scene(ROOT / "scenes/three-agents/none.yaml")
    found = metric.measure({"none": scene}, time_scales=[1.0, "auto"], progress=lambda line: None)
    assert [one.time_scale for one in found] == [1.0, "auto"]
    assert all(one.found and one.iterations > 0 for one in found)
    assert found[0].cost == pytest.approx(found[1].cost, rel=0.01)


def test_the_command_writes_both_tables(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(metric, "measure", lambda scenes, progress: TRIALS)
    command = ("bench", "metric", "--scenes", ROOT / "scenes", "--only", "gap", "-o", tmp_path)
    assert stplan(*command) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"metric.csv", "metric.md"}
    assert "1 of 2" in capsys.readouterr().out
