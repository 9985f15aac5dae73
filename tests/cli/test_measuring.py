"""measure as a command: its files, and what it says where PedPy is missing."""

from __future__ import annotations

import importlib

import pytest

from stplan import optional
from tests.viewing.runs import hall_run


@pytest.fixture
def hall(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return hall_run(tmp_path)


def test_tables_and_pictures_go_beside_the_run(hall, run):
    result = run("measure", hall, "--line", "0,-3,0,2", "--area", "-2,-3,2,1", "--json")
    assert result.status == 0
    made = {path.name for path in (hall / "measure").iterdir()}
    assert made == {
        "evacuation.csv", "evacuation.png", "crossings-line-1.csv", "flow-line-1.csv",
        "fundamental-diagram-area-1.csv", "fundamental-diagram.png", "density.png",
    }  # fmt: skip
    assert result.json["flows"]["line-1"] > 0.0
    assert (hall / "measure" / "density.png").read_bytes().startswith(b"\x89PNG")
    # What is measured of a run is no part of it.
    assert run("check", hall).status in (0, 1)


def test_the_same_run_gives_the_same_bytes(hall, run):
    for folder in ("one", "two"):
        assert run("measure", hall, "--area", "-2,-3,2,1", "-o", folder).status == 0
    for path in (hall.parent / "one").iterdir():
        assert path.read_bytes() == (hall.parent / "two" / path.name).read_bytes()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--line", "1,2"], "--line '1,2': expected x1,y1,x2,y2"),
        (["--area", "1,2,x"], "--area '1,2,x': expected xmin,ymin,xmax,ymax"),
        (["--dt", "0"], "--dt is 0.0; expected a number above 0"),
        (["--area", "0,0,1,1,1,0,0,1"], "PedPy: "),
    ],
)
def test_what_cannot_be_measured_is_refused(hall, run, words, message):
    result = run("measure", hall, *words)
    assert result.status == 2
    assert message in result.err
    assert not (hall / "measure").exists()


def test_without_pedpy_it_says_how_to_get_it(hall, run, monkeypatch):
    def missing(name: str):
        if name == "pedpy":
            raise ImportError(name)
        return importlib.import_module(name)

    monkeypatch.setattr(optional, "import_module", missing)
    result = run("measure", hall)
    assert result.status == 2
    assert "stplan measure needs the package pedpy: pip install 'stplan[measure]'" in result.err
