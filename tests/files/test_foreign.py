"""Trajectories of other programs are read as they mean it, and refused where they mean nothing."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np
import pytest

from stplan.errors import UsageError
from stplan.exports.registry import EXPORTS
from stplan.exports.settings import ExportSettings
from stplan.files.trajectories import read_trajectories
from stplan.viewing.run_view import open_run
from tests.viewing.runs import hall_run

PEDPY = """#framerate: 10
#ID\tFR\tx/m\ty/m\tz/m
2\t0\t0.0\t0.0\t0
2\t10\t1.0\t0.5\t0
1\t5\t3\t3\t0
1\t6\t3\t4\t0
"""
VADERE = "pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1\n1 0.0 0.4 1.0 2.0\n1 0.4 0.8 1.5 2.0\n"


def read(tmp_path: Path, name: str, text: str, fps: float | None = None):
    (tmp_path / name).write_text(text)
    return read_trajectories(tmp_path / name, fps)


def test_text_of_pedpy(tmp_path: Path) -> None:
    lines = read(tmp_path, "t.txt", PEDPY)
    assert lines.agent_ids == ("2", "1")
    np.testing.assert_array_equal(lines.curve(0), [[0, 0, 0], [1, 0.5, 1]])
    np.testing.assert_array_equal(lines.curve(1), [[3, 3, 0.5], [3, 4, 0.6]])
    centimetres = read(tmp_path, "cm.txt", PEDPY.replace("x/m", "x/cm"))
    np.testing.assert_allclose(centimetres.curve(0)[1], [0.01, 0.005, 1])


@pytest.mark.parametrize(
    "text",
    [
        "id,time,pos_x,pos_y\na,0,1,2\na,1,3,4\n",
        "Agent;T;X;Y;speed\na;1;3;4;9\na;0;1;2;9\n",
        "frame\tped\ty\tx\n0\ta\t2\t1\n25\ta\t4\t3\n",
    ],
)
def test_tables_with_other_columns(text: str, tmp_path: Path) -> None:
    lines = read(tmp_path, "t.csv", text, 25.0)
    assert lines.agent_ids == ("a",)
    np.testing.assert_array_equal(lines.curve(0), [[1, 2, 0], [3, 4, 1]])


def test_trajectories_of_vadere(tmp_path: Path) -> None:
    lines = read(tmp_path, "postvis.traj", VADERE)
    np.testing.assert_array_equal(lines.curve(0), [[1, 2, 0], [1.5, 2, 0.4]])


@pytest.mark.parametrize("form", ["jupedsim", "jupedsim-sqlite", "csv", "mcap", "geojson"])
def test_what_is_exported_is_read_back(form: str, tmp_path: Path) -> None:
    view = open_run(hall_run(tmp_path))
    path = tmp_path / EXPORTS[form].file
    path.write_bytes(EXPORTS[form].write(view, ExportSettings(0.5)))
    lines = read_trajectories(path)
    names = (
        [name.rpartition("_")[0] for name in lines.agent_ids] if form == "mcap" else lines.agent_ids
    )
    assert sorted(names) == ["ann", "ben", "cat"]
    times = np.arange(2.0, 7.0, 0.5)
    for name, curve in zip(names, lines.curves(), strict=True):
        true = view.lines.curve(view.rows[name])
        for axis in range(2):
            read_places = np.interp(times, curve[:, 2], curve[:, axis])
            np.testing.assert_allclose(
                read_places, np.interp(times, true[:, 2], true[:, axis]), atol=1e-6
            )


def _database(path: Path, *statements: str) -> Path:
    with sqlite3.connect(path) as connection:
        for statement in statements:
            connection.execute(statement)
    connection.close()
    return path


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("t.txt", "", "holds no trajectories"),
        ("t.txt", "1 0 0 0\n1 1 1 1\n", "--fps says it"),
        ("t.txt", "#framerate: 10\n1 0 0 0\n", "there only once"),
        ("t.txt", "#framerate: 10\n1 0 0 0\n1 0 1 1\n", "two places at one time"),
        ("t.txt", "#framerate: 10\n1 0 0\n", r"t\.txt:2: 3 values are too few"),
        ("t.txt", "#framerate: 10\n1 0 nan 0\n1 1 0 0\n", "not finite"),
        ("t.txt", "#framerate: 10\n1 0 0 0\n1 1 x 0\n", r"t\.txt:3: 'x' is no number"),
        ("t.csv", "id,time,x,y\na,0,1e300,1\na,1,1,1\n", "too large"),
        ("t.traj", "who when where\n1 2 3\n", "names no columns"),
        ("t.sqlite", "no database", "is no trajectory file"),
        ("t.mcap", "no bag", "is no MCAP file"),
        ("t.geojson", "[]", "is no GeoJSON"),
        ("t.geojson", '{"features": []}', "holds no trajectories"),
        ("t.doc", "", r"expected a \.csv file"),
    ],
)
def test_what_means_nothing_is_refused(name: str, text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=said):
        read(tmp_path, name, text)


def test_a_database_without_its_tables_is_refused(tmp_path: Path) -> None:
    path = _database(tmp_path / "t.sqlite", "CREATE TABLE metadata (key TEXT, value TEXT)")
    with pytest.raises(UsageError, match="no such table: trajectory_data"):
        read_trajectories(path)
