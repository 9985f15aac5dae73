"""Flow figures: what passes a line, what is in an area, who has arrived; and where runs are measured."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import UsageError
from stplan.exports.flow import flow_figures
from stplan.exports.flow_tables import csv_files, sentences
from stplan.exports.probes import Probe, probes_of
from stplan.scene.places import Place
from stplan.viewing.run_view import open_run
from tests.viewing.runs import write_run

# Ten walkers at 1 m/s, a metre apart, leave a corridor of 2 m on a line; one stays behind.
COUNT = 10
SCENE = (
    """\
stplan: 1
name: corridor
horizon: 20
map: {rectangle: [-12, -1, 6, 1]}
places: {exit: {line: [[4, -1], [4, 1]]}}
defaults: {radius: 0.2, after_arrival: vanish}
agents:
"""
    + "".join(f"  - {{id: a{k}, start: [{-k}, 0], goal: {{place: exit}}}}\n" for k in range(COUNT))
    + "  - {id: z, start: [-11, 0], goal: [-10.5, 0], after_arrival: stay}\n"
)
CURVES = [np.array([[-k, 0.0, 0.0], [4.0, 0.0, 4.0 + k]]) for k in range(COUNT)]
CURVES.append(np.array([[-11.0, 0.0, 0.0], [-10.5, 0.0, 5.0]]))
AREA = Probe("middle", ((-8.0, -1.0), (-4.0, -1.0), (-4.0, 1.0), (-8.0, 1.0)), area=True)


@pytest.fixture
def view(tmp_path):
    return open_run(write_run(tmp_path, SCENE, CURVES))


def test_all_cross_the_line_on_which_they_vanish(view):
    (exit_line,) = probes_of([], [], view.places)
    (line,) = flow_figures(view, (exit_line,), 0.1).lines
    assert line.probe.name == "exit"
    assert line.crossings[-1, 1] == COUNT
    # One a second.
    assert line.mean_flow == pytest.approx(1.0, rel=0.01)
    assert line.flows[:, 1] == pytest.approx(np.ones(len(line.flows)), rel=0.02)
    assert np.interp(8.05, *line.crossings.T) == 5


def test_density_and_speed_are_those_of_the_queue(view):
    (area,) = flow_figures(view, (AREA,), 0.5).areas
    times, classic, voronoi, speed, flow = area.rows.T
    early = (times > 0.5) & (times < 1.0 + 1e-9)
    # One a metre of the corridor that is 2 m wide, at 1 m/s.
    assert voronoi[early] == pytest.approx(0.5, rel=0.1)
    assert classic[early] == pytest.approx(0.5, rel=0.3)
    assert speed[early] == pytest.approx(1.0, rel=0.02)
    assert flow == pytest.approx(voronoi * speed, nan_ok=True)


def test_the_evacuation_curve_counts_everybody(view):
    table = flow_figures(view, (), 0.5).evacuation
    assert table[0].tolist() == [0.0, COUNT + 1, 0.0]
    assert table[-1, 1:].tolist() == [0.0, COUNT + 1]
    assert [int(np.interp(when, table[:, 0], table[:, 2])) for when in (3.5, 4.5, 5.0)] == [0, 1, 3]


def test_tables_and_words_hold_the_figures(view):
    (exit_line,) = probes_of([], [], view.places)
    figures = flow_figures(view, (exit_line, AREA), 0.5)
    files = csv_files(figures)
    assert set(files) == {
        "evacuation.csv", "crossings-exit.csv", "flow-exit.csv", "fundamental-diagram-middle.csv",
    }  # fmt: skip
    rows = files["evacuation.csv"].decode().splitlines()
    assert rows[:2] == ["time_s,on_the_way,arrived", "0,11,0"]
    said = "\n".join(sentences(figures))
    assert "11 have arrived at 13.00 s" in said
    assert "exit: 10 cross, 1.00 a second, 0.50 a second and metre" in said
    assert "without headings or body ellipses" in said


def test_probes_are_read_or_refused():
    (line, box, triangle) = probes_of(["0,1,2,3"], ["0,0,2,1", "0,0,1,0,0,1"], ())
    assert line == Probe("line-1", ((0.0, 1.0), (2.0, 3.0)), area=False)
    assert box.points == ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))
    assert len(triangle.points) == 3
    bent = Place("exit", ((0, 0), (1, 0), (1, 1)), area=False)
    assert [one.name for one in probes_of([], [], (bent,))] == ["exit-1", "exit-2"]
    for lines, areas in ((["0,1,2"], []), (["a,b,c,d"], []), ([], ["0,1"]), (["0,0,1,nan"], [])):
        with pytest.raises(UsageError, match="expected x"):
            probes_of(lines, areas, ())
