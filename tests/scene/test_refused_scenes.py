"""Refusals of maps, pairs, names and whole scenes; all faults of a scene at once."""

from __future__ import annotations

import os

import pytest

from stplan.scene import parse_scene
from tests.scene.samples import (
    PAIR,
    TRIANGLE,
    agents_text,
    edited,
    places,
    refusal,
    refusals,
    scene_text,
)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            "{between: [sam, anne], distance: 1}",
            "4:19: pairs[0].between[1]: there is no agent 'anne'; did you mean 'ann'?",
        ),
        (
            "{between: [sam, [ann, bob]], distance: 1}",
            "4:19: pairs[0].between[1]: there is no agent 'bob'",
        ),
        (
            "{between: [sam], distance: 1}",
            "4:4: pairs[0].between: is a list of 1; at least 2 is expected",
        ),
        (
            "{between: [sam, sam], distance: 1}",
            "4:4: pairs[0].between: is an agent and itself; two agents are expected",
        ),
        (
            "{between: [sam, 3], distance: 1}",
            "4:19: pairs[0].between[1]: is 3; an agent's id, all, a list of ids, "
            "or {start: PLACE} or {goal: PLACE} is expected",
        ),
        (
            "{between: [sam, []], distance: 1}",
            "4:19: pairs[0].between[1]: is a list of 0; an agent's id, all, a list of ids, "
            "or {start: PLACE} or {goal: PLACE} is expected",
        ),
        (
            "{between: [sam, ann]}",
            "4:3: pairs[0]: changes nothing; one of distance, grouping, collision, clearance, collide, "
            "meet is expected",
        ),
        (
            "{between: [sam, ann], distance: 0}",
            "4:25: pairs[0].distance: is 0; more than 0 is expected",
        ),
        (
            "{between: [sam, ann], collide: 'no'}",
            "4:25: pairs[0].collide: is 'no'; true or false is expected",
        ),
    ],
)
def test_pair(entry, message):
    text = edited("agents:", f"pairs:\n- {entry}\nagents:")
    # The line of `pairs:` itself is the fourth.
    line, rest = message.split(":", 1)
    assert refusals(text) == [f"scene.yaml:{int(line) + 1}:{rest}"]


@pytest.mark.parametrize(
    ("entry", "messages"),
    [
        ("{}", ["4:1: map: has none of mesh, file, polygon and rectangle; one is expected"]),
        (
            "{rectangle: [0, 0, 1, 1], polygon: [[0, 0], [1, 1], [1, 0]]}",
            ["4:1: map: has polygon and rectangle of mesh, file, polygon and rectangle; one is"],
        ),
        (
            "{rectangle: [2, 0, 0, -1], up: z, holes: []}",
            [
                "4:7: map.rectangle: reaches from xmin 2 to xmax 0; "
                "[xmin, ymin, xmax, ymax] with xmin < xmax is expected",
                "4:7: map.rectangle: reaches from ymin 0 to ymax -1; "
                "[xmin, ymin, xmax, ymax] with ymin < ymax is expected",
                "4:33: map.up: belongs to a mesh, and there is none",
                "4:40: map.holes: belongs to a polygon; with other bases, obstacles do the same",
            ],
        ),
        (
            "{rectangle: [0, 0, 1]}",
            ["4:7: map.rectangle: is a list of 3; a rectangle [xmin, ymin, xmax, ymax] in m is"],
        ),
        (
            "{polygon: [[0, 0], [1, 1], [1, 0], [0, 1]], repair: false}",
            [
                "4:7: map.polygon: touches or crosses itself at (0.5, 0.5); a simple ring is expected"
            ],
        ),
        (
            "{polygon: [[0, 0], [1, 1], [0, 0]]}",
            ["4:7: map.polygon: has 2 distinct points; a ring of at least 3 is expected"],
        ),
        ("{polygon: [[0, 0], [1, 1]]}", ["4:7: map.polygon: is a list of 2; at least 3 is"]),
        (
            "{polygon: [[0, 0], [9, 0], [9, 9], [0, 9]], holes: [[[8, 8], [10, 8], [8, 10]]], "
            "repair: false}",
            ["4:58: map.holes[0]: reaches the edge of the polygon at (9, 9); holes inside the"],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{}, {rectangle: [1, 1, 0, 2]}]}",
            [
                "4:44: map.obstacles[0]: has none of rectangle, polygon, circle and line; one is",
                "4:49: map.obstacles[1].rectangle: reaches from xmin 1 to xmax 0; ",
            ],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{circle: {center: [1, 1], radius: 0}}]}",
            ["4:70: map.obstacles[0].circle.radius: is 0; more than 0 is expected"],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{polygon: [[1, 1], [2, 2]]}]}",
            [
                "4:45: map.obstacles[0].polygon: is a list of 2; at least 3 is expected; "
                "a wall without an area is a `line`"
            ],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{line: [[1, 1], [1, 1]], thickness: -1}]}",
            ["4:69: map.obstacles[0].thickness: is -1; more than 0 is expected"],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{line: [[1, 1], [1, 1]]}]}",
            ["4:45: map.obstacles[0].line: is a single point; a line through at least 2 is"],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{line: [[1, 1]]}]}",
            ["4:45: map.obstacles[0].line: is a list of 1; at least 2 is expected"],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{rectangle: [1, 1, 2, 2], thickness: 1}]}",
            ["4:70: map.obstacles[0].thickness: belongs to a line, and there is none"],
        ),
        ("{mesh: no.obj}", ["4:7: map.mesh: there is no file 'no.obj' beside the scene"]),
        ('{mesh: "a\\0.obj"}', ["4:7: map.mesh: there is no file 'a\\x00.obj' beside the scene"]),
        ("{mesh: .}", ["4:7: map.mesh: '.' is no regular file; a mesh file is expected"]),
        ("{mesh: pipe.obj}", ["4:7: map.mesh: 'pipe.obj' is no regular file; a mesh file is"]),
        ("{mesh: big.obj}", ["4:7: map.mesh: 'big.obj' is larger than 100 MiB"]),
        (
            "{mesh: map.txt}",
            ["4:7: map.mesh: is 'map.txt'; a file that ends in .obj, .ply, .off, .stl, .glb is"],
        ),
        (f"{{mesh: {'x' * 900}.obj}}", ["4:7: map.mesh: "]),
    ],
)
def test_map(tmp_path, entry, messages):
    (tmp_path / "map.txt").write_text("")
    os.mkfifo(tmp_path / "pipe.obj")
    with (tmp_path / "big.obj").open("wb") as file:
        file.truncate(101 * 2**20)
    found = refusals(edited("agents:", f"map: {entry}\nagents:"), directory=tmp_path)
    assert len(found) == len(messages)
    for message, expected in zip(found, messages, strict=True):
        assert message.startswith(f"scene.yaml:{expected}")


@pytest.mark.parametrize(
    "mesh", ["absent.obj", "''", '"a\\0b.obj"', "maps", "a.txt", "a", "../absent.obj", "/dev/zero"]
)
def test_meshes_that_are_none(tmp_path, mesh):
    (tmp_path / "maps").mkdir()
    for file in ("a.txt", "a"):
        (tmp_path / file).write_text(TRIANGLE, encoding="utf-8")
    message = refusal(scene_text(top=f"map: {{mesh: {mesh}}}"), directory=tmp_path)
    assert "map.mesh: " in message


@pytest.mark.parametrize(
    "name", ["../x", "/etc", "a/b", "A", "", ".", "-a", "'a\\n'", '"a\\n"', "a b", "3"]
)
def test_names_that_are_no_folder(name):
    assert "name: " in refusal(scene_text(top=f"name: {name or repr('')}"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1]", "1:1: is a list of 1; a scene, a mapping of keys to values, is expected"),
        ("3", "1:1: is 3; a scene, a mapping of keys to values, is expected"),
        (
            "stplan: 1\nhorizon: 1\nagents: []",
            "3:1: agents: is a list of 0; at least 1 is expected",
        ),
        ("stplan: 1\nhorizon: 1\nagents: 3", "3:1: agents: is 3; a list is expected"),
        (
            "stplan: 1\nhorizon: 1",
            "1:1: agents: is missing; expected is: the moving things, in the order of the outputs",
        ),
        (
            "stplan: 1\nhorizon: 1\nagents: [3]",
            "3:10: agents[0]: is 3; a mapping of keys to values is expected",
        ),
    ],
)
def test_no_scene(text, message):
    assert refusals(text) == [f"scene.yaml:{message}"]


def test_all_faults_at_once_in_the_order_of_the_file():
    text = """\
stplan: 1
horizn: 20
horizon: 20
map: {mesh: nowhere.obj}
agents:
  - {id: sam, start: [0, 0], goal: [1, 1], radius: -1}
  - {id: sam, start: [0, 9], goal: [1, 9], preferred_time: 40}
  - {id: ann, start: [0, 0]}
  - {id: ann, start: [0, 5], goal: [1, 5], mass: 1, mass: 2}
pairs:
  - {between: [sam, an], distance: 1}
solver: {mu: fast}
"""
    assert [message.split(";")[0] for message in refusals(text)] == [
        "scene.yaml:2:1: horizn: unknown key",
        "scene.yaml:4:7: map.mesh: there is no file 'nowhere.obj' beside the scene",
        "scene.yaml:6:44: agents[0].radius: is -1",
        "scene.yaml:7:6: agents[1].id: is 'sam', as is agents[0].id",
        "scene.yaml:7:44: agents[1].preferred_time: is 40 s",
        "scene.yaml:8:5: agents[2].goal: is missing",
        "scene.yaml:9:6: agents[3].id: is 'ann', as is agents[2].id",
        "scene.yaml:9:53: agents[3].mass: this key stands here twice, first in line 9, column 44",
        "scene.yaml:11:21: pairs[0].between[1]: there is no agent 'an'",
        "scene.yaml:12:10: solver.mu: is 'fast'",
    ]


def test_faults_of_kinds_and_of_rules_are_told_in_order():
    text = (
        "solver: {alpha: 0}\nstplan: 1\nhorizon: -1\nagents:\n"
        "  - {id: sam, start: [0, 0], goal: [5], mass: 0, colour: red}\n"
        "time_scale: x\nsovler: {}\n"
    )
    messages = refusals(text)
    assert len(messages) == 7
    assert places(messages) == sorted(places(messages))
    rules = refusals(
        "pairs: [{between: [sam, bob], collide: false}]\n"
        + agents_text(
            "id: sam, start: [0, 0], goal: [1, 1], preferred_time: 40", "id: sam, start: [3, 3]"
        )
        + "map: {rectangle: [1, 1, 0, 0]}\n"
    )
    # Both sides of the rectangle are the wrong way round, the second agent has no goal and a known id.
    assert len(rules) == 6
    assert places(rules) == sorted(places(rules))


def test_a_fault_of_the_defaults_is_told_once():
    text = edited("agents:", "defaults: {weights: {arrival: 1}}\nagents:")
    assert refusals(text) == [
        "scene.yaml:4:22: defaults.weights.arrival: is 1, but preferred_time is missing; "
        "a time in s is expected"
    ]


def test_an_overlap_names_one_witness_and_counts_the_rest():
    crowd = "".join(f"  - {{id: a{k}, start: [0, 0], goal: [{k}, 0]}}\n" for k in range(4))
    found = refusals(f"stplan: 1\nhorizon: 9\nagents:\n{crowd}")
    assert len(found) == 3
    assert found[2].startswith(
        "scene.yaml:7:14: agents[3].start: is 0 m from the start of 'a0' (and too near 2 more), "
    )


@pytest.mark.parametrize(
    "change",
    [
        ("radius: 0.3\n", "start_time: 1.0\n"),
        ("agents:", "pairs: [{between: [sam, all], collide: false}]\nagents:"),
        ("agents:", "pairs: [{between: [[ann], sam], distance: 0.05}]\nagents:"),
        ("agents:", "defaults: {weights: {collision: 0}}\nagents:"),
    ],
)
def test_no_overlap_where_agents_may_meet(change):
    near = edited("start: [0.0, 5.0]", "start: [0.0, 0.1]")
    assert refusals(near)
    assert parse_scene(edited(*change, text=near)).name == "pair"


def test_vanishing_agents_may_share_a_goal():
    shared = edited("goal: [10.0, 5.0]", "goal: [10.0, 0.0]")
    assert refusals(shared)
    scene = parse_scene(edited("agents:", "defaults: {after_arrival: vanish}\nagents:", shared))
    assert scene.agents[0].goal == scene.agents[1].goal


def test_pair_of_examples_is_a_scene():
    assert [agent.id for agent in parse_scene(PAIR).agents] == ["sam", "ann"]
