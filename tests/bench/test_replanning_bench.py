"""How quickly plans are mended, measured on small ones."""

from __future__ import annotations

import math

from stplan.bench import replanning
from stplan.bench.replanning import MendedDraw, markdown_text, measure
from stplan.callbacks import unheard
from stplan.scene import parse_scene

ROOM = """\
stplan: 1
name: room
horizon: 20
map: {rectangle: [0, 0, 8, 6]}
defaults: {radius: 0.3}
solver: {effort: quick}
agents:
  - {id: ann, start: [1, 1], goal: [7, 1.5]}
  - {id: bob, start: [4, 5], goal: [3.5, 2.5]}
"""


def test_every_kind_of_event_is_drawn_mended_and_compared() -> None:
    measured = measure([parse_scene(ROOM)], 1, 1, progress=unheard)
    assert [one.kind for one in measured] == list(replanning.KINDS)
    assert all(one.certified and one.cost > 0.0 and one.seconds > 0.0 for one in measured)
    assert all(math.isfinite(one.afresh) for one in measured)
    # Whoever knew more, or searched longer, is hardly ever much dearer.
    assert all(one.cost < 2.0 * one.afresh for one in measured)


def test_the_table_counts_what_is_certified_and_refused() -> None:
    draws = [
        MendedDraw("hall", "delay", 20, 0.1, True, 11.0, 10.0),
        MendedDraw("hall", "delay", 20, 0.3, True, 5.0),
        MendedDraw("hall", "delay", 20, 2.0, None),
        MendedDraw("hall", "goal", 20, 0.5, None),
    ]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in markdown_text(draws).splitlines()[2:]
    ]
    assert rows == [
        ["hall", "20", "delay", "3", "2", "1", "0.30", "2.00", "+10.0", "1"],
        ["hall", "20", "goal", "1", "0", "1", "0.50", "0.50", "-", "0"],
    ]
    files = replanning.files(draws)
    assert set(files) == {"replanning.csv", "replanning.md"}
    assert files["replanning.csv"].decode().count("\n") == 5
