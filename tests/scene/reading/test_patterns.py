"""Patterns and tables: a few lines that stand for many agents."""

from __future__ import annotations

import pytest

from stplan.scene import parse_scene, scene_interactions
from stplan.scene.model import Agent
from tests.scene.samples import refusals

CIRCLE = "{pattern: circle, id: w, count: 6, circle: {center: [1, 2], radius: 5}"
LINE = "{pattern: line, id: w, count: 5, start: [[0, 0], [0, 4], [4, 4]], goal: [[9, 0], [9, 8]]"
GRID = "{pattern: grid, id: w, rows: 2, columns: 3, spacing: [1, 2], start: [0, 0], goal: [20, 5]"
HEADER = "id,start_x,start_y,goal_x,goal_y"


def text(entry: str, more: str = "", top: str = "") -> str:
    return f"stplan: 1\nhorizon: 20\nagents:\n  - {entry}{more and ', ' + more}}}\n{top}"


def agents(entry: str, more: str = "", **keys) -> tuple[Agent, ...]:
    return parse_scene(text(entry, more), **keys).agents


def test_circle():
    found = agents(CIRCLE, "radius: 0.2")
    assert [agent.id for agent in found] == ["w-1", "w-2", "w-3", "w-4", "w-5", "w-6"]
    assert found[0].start == (6.0, 2.0)
    assert found[0].goal == (-4.0, 2.0)
    for agent in found:
        # Opposite, to the last bit: all meet in one point.
        offsets = [(point[0] - 1.0, point[1] - 2.0) for point in (agent.start, agent.goal)]
        assert offsets[0] == pytest.approx((-offsets[1][0], -offsets[1][1]), abs=1e-15)
        assert sum(x * x for x in offsets[0]) == pytest.approx(25.0)
        assert agent.radius == 0.2
    turned = agents(CIRCLE, "first_angle: 90, turn: 90")
    assert turned[0].start == pytest.approx((1.0, 7.0))
    assert turned[0].goal == pytest.approx((-4.0, 2.0))


def test_line_along_a_polyline():
    found = agents(LINE)
    assert [agent.start for agent in found] == [(0, 0), (0, 2), (0, 4), (2, 4), (4, 4)]
    assert [agent.goal for agent in found] == [(9, 0), (9, 2), (9, 4), (9, 6), (9, 8)]
    alone = agents(
        "{pattern: line, id: w, count: 1, start: [[0, 0], [2, 0]], goal: [[0, 8], [2, 8]]"
    )
    assert (alone[0].start, alone[0].goal) == ((1, 0), (1, 8))


def test_grid():
    found = agents(GRID)
    assert [agent.start for agent in found] == [(0, 0), (1, 0), (2, 0), (0, 2), (1, 2), (2, 2)]
    assert found[4].goal == (21, 7)


def test_a_table(tmp_path):
    (tmp_path / "a.csv").write_text(
        f"{HEADER},radius,weights.wall,after_arrival\nsam,0,0,9,0,0.5,,vanish\n\nann,0,3,9,3,,2,\n",
        encoding="utf-8",
    )
    sam, ann = agents(
        "{file: a.csv, radius: 0.25, weights: {wall: 3, arrival: 0.5}, preferred_time: 12",
        directory=tmp_path,
    )
    assert (sam.id, sam.start, sam.goal, sam.radius) == ("sam", (0, 0), (9, 0), 0.5)
    assert (sam.after_arrival, ann.after_arrival) == ("vanish", "stay")
    assert (ann.radius, ann.weights.wall, ann.weights.arrival) == (0.25, 2.0, 0.5)
    assert sam.weights.wall == 3.0


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (f"{HEADER},speed\nsam,0,0,9,0,1\n", "the header has 'speed'; known columns are id, "),
        ("id,start_x,start_y,goal_x\nsam,0,0,9\n", "the header lacks goal_y"),
        (f"{HEADER},radius,radius\n", "the header has a column twice"),
        (f"{HEADER}\n", "there is no row after the header"),
        (f"{HEADER}\nsam,0,0,9\n", "line 2: 4 values; 5 are expected"),
        (f"{HEADER}\nsam,0,0,9,\n", "line 2: goal_y is empty"),
        (f"{HEADER}\nsam,0,x,9,0\n", "line 2: start_y is 'x'; a number in the range of this key"),
        (f"{HEADER},radius\nsam,0,0,9,0,-1\n", "line 2: radius is '-1'; a number"),
        (f"{HEADER}\nsam,0,0,9,nan\n", "line 2: goal_y is 'nan'; a number"),
        (f"{HEADER}\ns m,0,0,9,0\n", "line 2: id is 's m'; a name without white space"),
        (f"{HEADER},after_arrival\nsam,0,0,9,0,go\n", "after_arrival is 'go'; stay or vanish"),
        (f"{HEADER},weights.wall\nsam,0,0,9,0,x\n", "weights.wall is 'x'; a number"),
        (f'{HEADER}\n"sam,0,0,9,0\n', "is not well-formed CSV"),
    ],
)
def test_tables_that_are_refused(tmp_path, table, words):
    (tmp_path / "a.csv").write_text(table, encoding="utf-8")
    (message,) = refusals(text("{file: a.csv"), directory=tmp_path)
    assert message.startswith("scene.yaml:4:6: agents[0].file: a.csv: ")
    assert words in message


def test_a_table_that_is_not_there(tmp_path):
    (message,) = refusals(text("{file: b.csv"), directory=tmp_path)
    assert message == "scene.yaml:4:6: agents[0].file: there is no file 'b.csv' beside the scene"
    (tmp_path / "c.csv").write_bytes(b"\xff\xfe")
    assert "is not UTF-8" in refusals(text("{file: c.csv"), directory=tmp_path)[0]


def test_faults_of_a_pattern_are_told_once_and_where_they_stand():
    (message,) = refusals(text(CIRCLE, "max_time: 0.0"))
    assert message.startswith("scene.yaml:4:77: agents[0].max_time: max_time 0 s is not after")
    (message,) = refusals(text(CIRCLE, "radius: -1"))
    assert message.startswith("scene.yaml:4:77: agents[0].radius: is -1; more than 0")
    (message,) = refusals(text(CIRCLE, "radios: 1"))
    assert message.endswith("did you mean 'radius'?")
    (message,) = refusals(text(CIRCLE.replace("circle,", "cirlce,")))
    assert "agents[0].pattern: is 'cirlce'; circle, line or grid is expected" in message
    assert message.endswith("did you mean 'circle'?")
    (message,) = refusals(text(GRID.replace("rows: 2, ", "")))
    assert "agents[0].rows: is missing" in message


def test_members_that_overlap_are_named():
    messages = refusals(text(LINE, "radius: 1.0"))
    assert "agents[0][1].start: is 2 m from the start of 'w-1'" in messages[0]


def test_ids_are_unique():
    more = "  - {id: w-2, start: [50, 0], goal: [60, 0]}\n"
    (message,) = refusals(text(GRID, top=more))
    assert "agents[1].id: is 'w-2', as is agents[0][1].id" in message
    (message,) = refusals(text(GRID, top=more.replace("w-2", "w")))
    assert "agents[0].id: is 'w', as is agents[1].id" in message


def test_a_pattern_is_meant_by_its_id():
    more = (
        "  - {id: elk, start: [50, 0], goal: [60, 0]}\n"
        "pairs:\n  - {between: [w, elk], distance: 2.5}\n  - {between: [w-3, elk], collide: false}\n"
    )
    pairs = scene_interactions(parse_scene(text(GRID, top=more)))
    assert (pairs.distance[:6, 6] == 2.5).all()
    assert pairs.collides[6].tolist() == [True, True, False, True, True, True, False]
    assert (pairs.distance[:6, :6] == 0.6).all()
    (message,) = refusals(text(GRID, top=more.replace("w-3", "w-9")))
    assert "pairs[1].between[0]: there is no agent 'w-9'" in message


def test_overrides_find_patterns_by_id():
    scene = parse_scene(text(GRID), overrides=["agents.w.radius=0.1", "agents[0].rows=1"])
    assert [agent.radius for agent in scene.agents] == [0.1, 0.1, 0.1]


def test_the_hash_is_of_the_agents_not_of_how_they_are_listed():
    row = "{id: w-1, start: [1, 0], goal: [1, 8]"
    line = "{pattern: line, id: w, count: 1, start: [[0, 0], [2, 0]], goal: [[0, 8], [2, 8]]"
    assert parse_scene(text(row)).content_hash == parse_scene(text(line)).content_hash


def test_too_many_agents():
    entry = "{pattern: grid, id: w, rows: 200, columns: 200, spacing: [1, 1], start: [0, 0], goal: [0, 0]"
    messages = refusals(text(entry, "weights: {collision: 0}"))
    assert any("agents: are 40000" in message for message in messages)


def test_a_broken_pattern_has_no_followers():
    more = "pairs:\n  - {between: [w-2, w-3], distance: 2.5}\n"
    (message,) = refusals(text(CIRCLE.replace("count: 6", "count: 0"), top=more))
    assert "agents[0].count: is 0; at least 1 is expected" in message
