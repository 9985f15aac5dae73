"""The measurement on grid maps: fair instances, the same certificate for both, and its files."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from stplan import planner
from stplan.bench import movingai
from stplan.bench.movingai_table import files
from stplan.errors import UsageError
from stplan.world import fitted_free_space
from tests.maps.formats.samples import movingai as write_map


@pytest.fixture
def grid(tmp_path: Path) -> Path:
    return tmp_path / write_map(tmp_path)


def test_instances_are_repeatable_and_fit(grid: Path) -> None:
    free = movingai._free_cells(grid)
    assert free.sum() == 91
    starts, goals = movingai.draw_cells(free, 20, 3, grid)
    assert (starts, goals) == movingai.draw_cells(free, 20, 3, grid)
    assert len(set(starts)) == len(set(goals)) == 20
    scene = movingai.grid_scene(grid, free, starts, goals, 0.45)
    assert fitted_free_space(scene) is not None
    with pytest.raises(UsageError, match="91 free cells for 100 agents"):
        movingai.draw_cells(free, 100, 0, grid)


def test_paths_over_cells_are_judged_as_discs(grid: Path) -> None:
    free = movingai._free_cells(grid)
    starts, goals = [(7, 0), (6, 1)], [(7, 2), (7, 1)]
    paths = {"a1": [(7, 0), (7, 1), (7, 2)], "a2": [(6, 1), (6, 1), (7, 1)]}
    for share, holds in ((0.3, True), (0.45, False)):
        # One moves into the cell that the other leaves around a corner: 0.707 of a cell apart.
        scene = movingai.grid_scene(grid, free, starts, goals, share)
        lines = movingai.grid_lines(scene, 8, paths, 2)
        assert lines.curve(0)[-1, 2] == scene.horizon
        assert planner.check(scene, lines).holds is holds


def test_both_are_measured_and_written(grid: Path) -> None:
    outcomes = movingai.measure([grid], [3], [0.3], progress=lambda line: None)
    (one,) = outcomes
    assert one.planned
    assert one.rival == "certified"
    assert one.excess >= 0
    contents = files(outcomes)
    (row,) = csv.DictReader(contents["movingai.csv"].decode().splitlines())
    assert (row["map"], row["agents"], row["planned"]) == ("rooms", "3", "1")
    assert "certified" in contents["movingai.md"].decode()
    assert np.isfinite(one.rival_seconds)


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"expected a map that ends in \.map"):
        movingai.measure([tmp_path / "a.png"], [3], [0.3], progress=lambda line: None)
