"""Figures: sizes, formats, what is in them, true scale."""

from __future__ import annotations

import io
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PatchCollection, PathCollection
from PIL import Image

from stplan.scene.model import WorldChange
from stplan.viewing.drawing import look
from stplan.viewing.figure import FORMATS, draw_figure, figure_bytes
from stplan.viewing.palette import agent_colours
from stplan.viewing.run_view import open_run
from tests.viewing.runs import CURVES, HALL, hall_run, many_run, write_run


def _pixels(content: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)


def _svg_texts(content: bytes) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", content.decode())


@pytest.fixture
def view(tmp_path):
    return open_run(hall_run(tmp_path))


def test_every_format(view):
    files = {kind: figure_bytes(view, kind, parts=("map", "time")) for kind in FORMATS[1:]}
    assert files["pdf"].startswith(b"%PDF")
    texts = _svg_texts(files["svg"])
    for expected in (
        "Clearance",
        "Speed",
        "On the way, waiting, arrived",
        "wanted arrival",
        "waypoint",
    ):
        assert expected in texts
    assert texts.count("ann") >= 2
    assert any(text.startswith("ann and ben: 0.228 m") for text in texts)
    assert "initial curve" not in texts
    picture = _pixels(figure_bytes(view, "png", dpi=40))
    assert picture.shape[1] == 13 * 40
    assert 300 < picture.shape[0] < 500


def test_events_are_marked_and_named(view):
    assert view.events == ()
    assert b'id="event"' not in figure_bytes(view, "svg", parts=("time",))
    change = WorldChange(2.5, view.scene, causes=("the west door closed",))
    happened = replace(view, scene=replace(view.scene, changes=(change,)))
    content = figure_bytes(happened, "svg", parts=("time",))
    # In clearance, speed and arrivals; said in the last.
    assert content.count(b'id="event"') == 3
    assert _svg_texts(content).count("the west door closed") == 1


def test_every_agent_is_seen_in_its_colour(view):
    picture = _pixels(figure_bytes(view, "png", parts=("map",), dpi=60))
    for colour in 255 * agent_colours(3):
        # Colours are laid thinly over white: every channel is as far on the way from white.
        way = (255 - picture) / (255 - colour)
        alike = (np.ptp(way, axis=2) < 0.05) & (way.mean(axis=2) > 0.1)
        assert alike.sum() > 1000


def test_rods_of_many_agents_are_seen(tmp_path):
    view = open_run(many_run(tmp_path, 60))
    picture = _pixels(figure_bytes(view, "png", parts=("rods",), dpi=40))
    coloured = np.ptp(picture, axis=2) > 60
    assert coloured.mean() > 0.02


def test_initial_curves_on_request(view):
    texts = _svg_texts(figure_bytes(view, "svg", parts=("map",), seed=True))
    assert "initial curve" in texts
    assert "Clearance" not in texts


def test_paths_and_discs_are_at_true_scale(view):
    with look():
        figure = draw_figure(view, parts=("map",))
    (axes,) = figure.axes
    assert axes.get_aspect() == 1.0
    # Floor first, then what the three discs pass over.
    (swaths,) = (c for c in axes.collections if type(c) is PathCollection and c.zorder == 2)
    ann, ben, _ = swaths.get_paths()
    assert ann.get_extents().bounds == pytest.approx((-4.3, -0.3, 8.6, 0.6), abs=1e-3)
    assert ben.get_extents().width == pytest.approx(0.8, abs=1e-3)
    (discs,) = (c for c in axes.collections if isinstance(c, PatchCollection))
    widths = [path.get_extents().width for path in discs.get_paths()]
    assert sorted({round(width, 6) for width in widths}) == [0.6, 0.8]


def test_one_agent_alone(tmp_path):
    lines = HALL.splitlines()
    run = write_run(tmp_path, "\n".join(lines[:10]), [np.array([[-4.0, 0, 0], [4, 0, 8.0]])])
    texts = _svg_texts(figure_bytes(open_run(run), "svg", dpi=40))
    assert any(text.startswith("one agent,") for text in texts)
    assert any("ann and a wall" in text for text in texts)


def test_nobody_keeps_a_distance(tmp_path):
    text = "stplan: 1\nname: solo\nhorizon: 5\nagents: [{id: ann, start: [0, 0], goal: [0, 0]}]\n"
    run = write_run(tmp_path, text, [np.array([[0.0, 0, 0], [0, 0, 5.0]])])
    assert "nobody keeps a distance" in _svg_texts(figure_bytes(open_run(run), "svg", dpi=40))


def test_names_are_text_whatever_letters_they_are_of(tmp_path):
    text = HALL.replace("ann", "安娜").replace("two cross", "$2^ cost")
    texts = _svg_texts(figure_bytes(open_run(write_run(tmp_path, text, CURVES)), "svg"))
    assert "安娜" in texts
    assert any("$2^ cost, one waits" in text for text in texts)


def test_labels_thin_out_and_lists_fold_for_many_agents(tmp_path):
    def texts(count: int) -> list[str]:
        view = open_run(many_run(tmp_path / str(count), count))
        return _svg_texts(figure_bytes(view, "svg", parts=("map", "time")))

    few, many = texts(20), texts(150)
    assert few.count("a7") >= 2
    assert "a7" not in many
    assert "150 agents" in many
    assert "median" in many
    assert len(many) < len(few)
