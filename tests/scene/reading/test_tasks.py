"""Tasks of a file: what they mean, and what is wrong with them."""

from __future__ import annotations

from itertools import pairwise

import pytest

from stplan.scene import load_scene, parse_scene
from tests.scene.samples import refusal, refusals

TEXT = """\
stplan: 1
name: work
horizon: none
map: {rectangle: [0, 0, 10, 10]}
places: {shelf: {rectangle: [7, 7, 9, 9]}}
defaults: {radius: 0.3, max_speed: 1}
agents:
  - {id: ann, start: [1, 1]}
  - {id: bob, start: [1, 3], goal: [1, 5]}
tasks: {places: [shelf], points: [[5, 1], [5, 3]], each: 20, service: 2}
"""
TASKS = "{places: [shelf], points: [[5, 1], [5, 3]], each: 20, service: 2}"


def test_tasks_are_drawn_from_places_and_points() -> None:
    scene = parse_scene(TEXT)
    assert [agent.goal for agent in scene.agents] == [(1.0, 1.0), (1.0, 5.0)]
    assert [task.agent for task in scene.tasks] == ["ann"] * 20 + ["bob"] * 20
    assert {task.service for task in scene.tasks} == {2.0}
    where = {task.at for task in scene.tasks}
    assert {(5.0, 1.0), (5.0, 3.0)} < where
    shelf = where - {(5.0, 1.0), (5.0, 3.0)}
    assert len(shelf) > 5
    assert all(7 <= x <= 9 and 7 <= y <= 9 for x, y in shelf)
    other = parse_scene(TEXT + "seeding: {rng_seed: 1}\n")
    assert [one.at for one in other.tasks] != [one.at for one in scene.tasks]
    own = [task.at for task in scene.tasks[:20] if task.at not in shelf]
    assert len(own) > 5
    points = [task.at for task in scene.tasks[:20]]
    assert all(one != other for one, other in pairwise(points))


def test_a_table_says_whose_tasks_are_where(tmp_path) -> None:
    (tmp_path / "tasks.csv").write_text("agent,x,y,service\nbob,5,5,\nann,6,6,4\n")
    (tmp_path / "work.yaml").write_text(TEXT.replace(TASKS, "{file: tasks.csv, service: 1}"))
    tasks = load_scene(tmp_path / "work.yaml").tasks
    assert [(one.agent, one.at, one.service) for one in tasks] == [
        ("bob", (5.0, 5.0), 1.0),
        ("ann", (6.0, 6.0), 4.0),
    ]


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ("agent,x\nann,5\n", "the header lacks y"),
        ("agent,x,y,z\nann,5,5,5\n", "the header has 'z'"),
        (
            "agent,x,y\nan,5,5\n",
            "line 2: agent is 'an', which is no agent's id; did you mean 'ann'?",
        ),
        ("agent,x,y\nann,5,five\n", "line 2: y is 'five'; a number of m is expected"),
        ("agent,x,y,service\nann,5,5,-1\n", "line 2: service is '-1'; a time in s is expected"),
        ("agent,x,y\n", "there is no row after the header"),
        ("agent,x,y\nann,5\n", "line 2: 2 values; 3 are expected"),
    ],
)
def test_what_is_wrong_with_a_table(tmp_path, table: str, sentence: str) -> None:
    (tmp_path / "tasks.csv").write_text(table)
    text = TEXT.replace(TASKS, "{file: tasks.csv}")
    assert sentence in refusal(text, directory=tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "place", "sentence"),
    [
        ("horizon: none", "horizon: 30", "3:1: horizon", "`horizon: none` is expected"),
        (f"tasks: {TASKS}\n", "", "3:1: horizon", "there are no tasks"),
        ("[shelf]", "[shelv]", "tasks.places[0]", "did you mean 'shelf'?"),
        ("each: 20", "each: 20, shared: 5", "10:1: tasks", "has both of each and shared"),
        ("each: 20, ", "", "10:1: tasks", "has none of each and shared"),
        ("places: [shelf], points: [[5, 1], [5, 3]], ", "", "10:1: tasks", "no places, points or file"),
        ("each: 20", "each: 20, file: a.csv", "tasks.each", "goes without a file"),
        (TASKS, "{file: a.csv}", "tasks.file", "there is no file 'a.csv'"),
        ("each: 20", "each: 60000", "tasks.each", "makes 120000 tasks"),
        ("max_speed: 1", "mass: 1", "defaults.max_speed", "is missing"),
        ("max_speed: 1", "max_speed: 1, max_acceleration: 1", "max_acceleration", "start and stop at once"),
        ("goal: [1, 5]", "goal: {follow: ann, within: 2}", "goal", "points as goals"),
        ("[7, 7, 9, 9]", "[12, 7, 14, 9]", "tasks.places[0]", "no point that a disc of 0.3 m"),
    ],
)  # fmt: skip
def test_what_is_wrong(old: str, new: str, place: str, sentence: str) -> None:
    found = refusals(TEXT.replace(old, new))
    assert any(place in one and sentence in one for one in found), found
