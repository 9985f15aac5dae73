"""The growth of an iteration: its scenes, its fits and its files."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest
import shapely

from stplan.bench import plots, scaling
from stplan.bench.families_maze import maze, maze_floor
from stplan.bench.scaling_table import csv_text, markdown_text, picture
from stplan.bench.solves import SolveFigures
from stplan.cli.app import main
from stplan.errors import UsageError
from stplan.world import build_free_space, check_scene_in_world

PNG = b"\x89PNG\r\n"
AGENTS = scaling.SWEEPS["agents"]


def point(size, seconds, share=0.25, **changes):
    run = SolveFigures(
        size, status="converged", certified=True, optimise_seconds=10 * seconds, iterations=10,
        evaluation_share=share, hessian_nonzeros=100 * size,
    )  # fmt: skip
    return replace(scaling.Point(size, 0, size, run), **changes)


def test_more_edges_draw_the_same_maze():
    few, many = (maze(edges) for edges in (1000, 4000))
    rooms = [build_free_space(scene) for scene in (few, many)]
    assert [check_scene_in_world(*pair) for pair in zip((few, many), rooms, strict=True)] == [
        [],
        [],
    ]
    assert few.agents == many.agents
    counts = [len(room.boundary_edges) for room in rooms]
    assert counts == pytest.approx([1000, 4000], rel=0.1)
    # The same floor but for how finely its hedges are drawn.
    assert rooms[0].polygon.area == pytest.approx(rooms[1].polygon.area, rel=1e-2)
    assert len(rooms[0].polygon.interiors) == len(rooms[1].polygon.interiors) > 0


def test_lanes_of_a_maze_are_one_and_never_narrower_than_drawn():
    floor = maze_floor(np.random.default_rng(5))
    assert isinstance(floor, shapely.Polygon)
    assert isinstance(build_free_space(maze(1500, 5)).polygon.buffer(-0.8), shapely.Polygon)


def test_sizes_come_out_as_asked():
    assert len(AGENTS.scene(16, 0).agents) == 16
    assert scaling.SWEEPS["knots"].scene(60, 1).solver.knots == 60
    assert scaling.SWEEPS["walls"].scene(1000, 0).solver.knots == 200


def test_exponents_are_fitted_to_the_medians_of_what_was_planned():
    points = [point(size, 1e-3 * size**1.25) for size in (8, 16, 32, 64)]
    points += [
        replace(points[1], draw=1),
        replace(points[1], draw=2, run=SolveFigures(16, status="failed: x")),
    ]
    assert scaling.exponent(points, "iteration") == pytest.approx(1.25)
    assert scaling.exponent(points, "Hessian nonzeros") == pytest.approx(1.0)
    assert np.isnan(scaling.exponent(points[:1], "iteration"))
    text = markdown_text(AGENTS, points)
    assert "Time an iteration ~ size^1.25 (fitted); at most 1.2 is asked." in text
    assert "2 of 3" in text
    assert "nan" not in text + csv_text(points)


def test_parts_of_an_iteration_add_up():
    one = point(8, 0.02)
    assert one.part("iteration") == pytest.approx(20.0)
    assert one.part("evaluation") == pytest.approx(5.0)
    assert one.part("linear algebra and rest") == pytest.approx(15.0)


def test_the_same_points_give_the_same_picture():
    points = [point(size, 1e-3 * size) for size in (8, 16)]
    first, again = picture(AGENTS, points), picture(AGENTS, points)
    assert first == again
    assert first.startswith(PNG)


def test_the_command_writes_points_a_table_and_a_picture(tmp_path, capsys, monkeypatch):
    small = replace(AGENTS, small=(2, 4))
    monkeypatch.setitem(scaling.SWEEPS, "agents", small)
    with pytest.raises(SystemExit) as left:
        main(["bench", "agents", "-o", str(tmp_path)])
    assert left.value.code == 0
    out, err = capsys.readouterr()
    assert (tmp_path / "agents.md").read_text() == out
    assert (tmp_path / "agents.png").read_bytes().startswith(PNG)
    with (tmp_path / "agents.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["size"] for row in rows] == ["2", "4"]
    assert all(float(row["iteration_ms"]) > 0 for row in rows)
    assert all(row["certified"] == "1" for row in rows)
    assert "ms an iteration" in err


def test_without_matplotlib_the_command_says_so_before_it_measures(tmp_path, monkeypatch, capsys):
    def missing():
        raise UsageError("the figures of the benchmarks need matplotlib")

    monkeypatch.setattr(plots, "require_matplotlib", missing)
    with pytest.raises(SystemExit) as left:
        main(["bench", "walls", "-o", str(tmp_path)])
    assert left.value.code == 2
    assert capsys.readouterr().err == "the figures of the benchmarks need matplotlib\n"
    assert not list(tmp_path.iterdir())


def test_the_extra_that_brings_matplotlib_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match=r"pip install 'stplan\[docs\]'"):
        plots.require_matplotlib()
