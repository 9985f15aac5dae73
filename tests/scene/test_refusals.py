"""Every refusal says where, what is wrong and what is expected."""

from __future__ import annotations

import os

import pytest

from tests.scene.examples import PAIR, edited, refusals

RADIUS = "    radius: 0.3\n"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("radus: 0.3", "8:5: agents[0].radus: unknown key; did you mean 'radius'?"),
        ("Radius: 0.3", "8:5: agents[0].Radius: unknown key; did you mean 'radius'?"),
        (
            "colour: red",
            "8:5: agents[0].colour: unknown key; start_time, max_time, preferred_time, radius, "
            "mass, after_arrival, max_speed, max_acceleration, waypoints, weights, id, start, goal and "
            "path are known",
        ),
        (
            "radius: '0.3'",
            "8:5: agents[0].radius: is '0.3'; a number is expected "
            "(leave out the quotes, and zeros in front)",
        ),
        ("radius: wide", "8:5: agents[0].radius: is 'wide'; a number is expected"),
        ("radius: true", "8:5: agents[0].radius: is true; a number is expected"),
        ("radius: yes", "8:5: agents[0].radius: is true; a number is expected"),
        ("radius: -1", "8:5: agents[0].radius: is -1; more than 0 is expected"),
        ("radius: 0", "8:5: agents[0].radius: is 0; more than 0 is expected"),
        ("radius: 1e-12", "8:5: agents[0].radius: is 1e-12; at least 1e-09 is expected"),
        ("radius: 1e10", "8:5: agents[0].radius: is 10000000000.0; at most 1e+09 is expected"),
        ("radius: .nan", "8:5: agents[0].radius: is nan; a finite number is expected"),
        ("radius: .inf", "8:5: agents[0].radius: is inf; a finite number is expected"),
        (
            f"radius: 1{'0' * 350}",
            "8:5: agents[0].radius: is a number too large for a float; at most 1e+09 is expected",
        ),
        (
            f"radius: 1{'0' * 4999}",
            "8:5: agents[0].radius: is a number of 5000 characters, which is too long",
        ),
        (
            "radius:",
            "8:5: agents[0].radius: is empty; a number is expected "
            "(leave the key out for its default)",
        ),
        ("radius: [1]", "8:5: agents[0].radius: is a list of 1; a number is expected"),
        ("radius: {a: 1}", "8:5: agents[0].radius: is a mapping; a number is expected"),
        (
            "radius: 0.3\n    radius: 0.4",
            "9:5: agents[0].radius: this key stands here twice, first in line 8, column 5",
        ),
        ("mass: -80", "8:5: agents[0].mass: is -80; more than 0 is expected"),
        (
            "after_arrival: vanishes",
            "8:5: agents[0].after_arrival: is 'vanishes'; 'stay' or 'vanish' is expected; "
            "did you mean 'vanish'?",
        ),
        (
            "weights: {collison: 1}",
            "8:15: agents[0].weights.collison: unknown key; did you mean 'collision'?",
        ),
        (
            "weights: {regularity: atuo}",
            "8:15: agents[0].weights.regularity: is 'atuo'; a number or auto is expected; "
            "did you mean 'auto'?",
        ),
        ("weights: {wall: -1}", "8:15: agents[0].weights.wall: is -1; at least 0 is expected"),
        (
            "weights: {arrival: 1}",
            "8:15: agents[0].weights.arrival: is 1, but preferred_time is missing; "
            "a time in s is expected",
        ),
        (
            "preferred_time: 25",
            "8:5: agents[0].preferred_time: is 25 s; after start_time 0 s and no later than "
            "max_time 20 s is expected",
        ),
        (
            "preferred_time: 0",
            "8:5: agents[0].preferred_time: is 0 s; after start_time 0 s and no later than "
            "max_time 20 s is expected",
        ),
        (
            "max_time: 0",
            "8:5: agents[0].max_time: max_time 0 s is not after start_time 0 s; "
            "a later one is expected",
        ),
        (
            "start_time: 30",
            "8:5: agents[0].start_time: is 30 s; less than the horizon 20 s is expected",
        ),
        (
            "waypoints: [[1, 2], [3]]",
            "8:25: agents[0].waypoints[1]: is a list of 1; a point [x, y] in m is expected",
        ),
        ("path: [[0, 0, 0]]", "8:5: agents[0].path: is a list of 1; at least 2 is expected"),
        (
            "path: [[0, 0, 0], [1, 0, 0], [10, 0, 3]]",
            "8:30: agents[0].path[1][2]: is at 0 s; later than the knot before is expected (0 s)",
        ),
        (
            "path: [[0, 0, 0], [10, 0]]",
            "8:23: agents[0].path[1]: is a list of 2; a knot [x, y, t] in m and s is expected",
        ),
    ],
)
def test_key_of_an_agent(line, message):
    assert refusals(edited(RADIUS, f"    {line}\n")) == [f"scene.yaml:{message}"]


def test_what_contradicts_a_path():
    text = edited(
        RADIUS,
        "    path: [[0, 1, 0], [9, 0, 3]]\n    start_time: 1\n    max_time: 2\n"
        "    waypoints: [[1, 1]]\n",
    )
    assert refusals(text) == [
        "scene.yaml:6:5: agents[0].start: is not the path's end (0, 1); leave it out",
        "scene.yaml:7:5: agents[0].goal: is not the path's end (9, 0); leave it out",
        "scene.yaml:9:5: agents[0].start_time: is 1 s, the path starts at 0 s; leave it out",
        "scene.yaml:10:5: agents[0].max_time: is 2 s, the path ends at 3 s; leave it out",
        "scene.yaml:11:5: agents[0].waypoints: belongs to agents that find their way; "
        "one with a path passes its knots",
    ]


BAD_NAME = "a name without white space and without any of ,;=\"'`[]{}\\ (not %s) is expected"


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("all", "is 'all', which means every agent; another id is expected"),
        ("1", "is 1; text is expected (in quotes it is text: '1')"),
        (
            "no",
            "is false; text is expected (YAML reads an unquoted no as false; in quotes it is text)",
        ),
        ("null", "is empty; text is expected (leave the key out for its default)"),
        ("''", "is ''; text of at least 1 character is expected"),
        ("x" * 101, f"is '{'x' * 56}...; text of at most 100 characters is expected"),
        ("'a b'", f"is 'a b'; {BAD_NAME % 'U+0020'}"),
        ("'a,b'", f"is 'a,b'; {BAD_NAME % ','}"),
        ('"a\\nb"', f"is 'a\\nb'; {BAD_NAME % 'U+000A'}"),
        ('"a\\u202eb"', f"is 'a\\u202eb'; {BAD_NAME % 'U+202E'}"),
        ("'=1+1'", f"is '=1+1'; {BAD_NAME % '='}"),
    ],
)
def test_id(written, message):
    assert refusals(edited("id: sam", f"id: {written}")) == [
        f"scene.yaml:5:5: agents[0].id: {message}"
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("stplan: 1\n", "", "1:1: stplan: is missing; expected is: version of this format"),
        ("stplan: 1", "stplan: 2", "1:1: stplan: is 2; 1 is expected"),
        (
            "stplan: 1",
            "stplan: '1'",
            "1:1: stplan: is '1'; 1 is expected (leave out the quotes, and zeros in front)",
        ),
        (
            "stplan: 1",
            "stplan: true",
            "1:1: stplan: is true; 1, the only version of the format there is, is expected",
        ),
        (
            "name: pair",
            "name: ../../etc",
            "2:1: name: is '../../etc'; text that matches ^[a-z0-9][a-z0-9_-]*$ is expected",
        ),
        (
            "name: pair",
            'name: "pair\\n"',
            "2:1: name: is 'pair\\n'; text that matches ^[a-z0-9][a-z0-9_-]*$ is expected",
        ),
        ("name: pair", "name: 3", "2:1: name: is 3; text is expected (in quotes it is text: '3')"),
        (
            "horizon: 20.0\n",
            "",
            "1:1: horizon: is missing; a time in s is expected, or a max_time of every agent",
        ),
        ("horizon: 20.0", "horizon: -1", "3:1: horizon: is -1; more than 0 is expected"),
        ("id: sam", "id: ann", "9:5: agents[1].id: is 'ann', as is agents[0].id; unique ids are"),
        (
            "    start: [0.0, 0.0]\n",
            "",
            "5:5: agents[0].start: is missing; a point [x, y] in m is expected, or a path",
        ),
        (
            "  - id: sam\n    start",
            "  - start",
            "5:5: agents[0].id: is missing; expected is: name of the agent, unique; "
            "`all` is reserved",
        ),
        (
            "start: [0.0, 0.0]",
            "start: [0.0, x]",
            "6:18: agents[0].start[1]: is 'x'; a number is expected",
        ),
        (
            "start: [0.0, 5.0]",
            "start: [0.0, 0.1]",
            "10:5: agents[1].start: is 0.1 m from the start of 'sam', and both start at once; "
            "more than 0.6 m is expected of agents that collide",
        ),
        (
            "goal: [10.0, 5.0]",
            "goal: [10.0, 0.6]",
            "11:5: agents[1].goal: is 0.6 m from the goal of 'sam', and both stay on their "
            "goals; more than 0.6 m is expected of agents that collide",
        ),
        (
            "agents:",
            "defaults: {start: [0, 0]}\nagents:",
            "4:12: defaults.start: is for each agent to say; "
            "any other key of agents is expected in defaults",
        ),
        (
            "agents:",
            "defaults: {preferred_time: 30}\nagents:",
            "4:12: defaults.preferred_time: is 30 s; after start_time 0 s and no later than "
            "max_time 20 s is expected",
        ),
        (
            "agents:",
            "defaults:\nagents:",
            "4:1: defaults: is empty; a mapping of keys to values is expected "
            "(leave the key out for its default)",
        ),
        ("agents:", "time_scale: 0\nagents:", "4:1: time_scale: is 0; more than 0 is expected"),
        (
            "agents:",
            "seeding: {method: djikstra}\nagents:",
            "4:11: seeding.method: is 'djikstra'; 'auto', 'dijkstra', 'search' or 'relaxation' "
            "is expected; did you mean 'dijkstra'?",
        ),
        (
            "agents:",
            "seeding: {layers: 1.5}\nagents:",
            "4:11: seeding.layers: is 1.5; a whole number is expected",
        ),
        (
            "agents:",
            "seeding: {margin: 0.9}\nagents:",
            "4:11: seeding.margin: is 0.9; at least 1 is expected",
        ),
        (
            "agents:",
            "solver: {knots: 2}\nagents:",
            "4:10: solver.knots: is 2; at least 3 is expected",
        ),
        (
            "agents:",
            "solver: {barrier_range: 0}\nagents:",
            "4:10: solver.barrier_range: is 0; more than 0 is expected",
        ),
        (
            "agents:",
            "solver: {barrier_range: none}\nagents:",
            "4:10: solver.barrier_range: is 'none'; a number or auto or inf is expected",
        ),
        (
            "agents:",
            "solver: {barrier_range: .nan}\nagents:",
            "4:10: solver.barrier_range: is nan; a finite number is expected",
        ),
        (
            "agents:",
            "solver: {alpha: .inf}\nagents:",
            "4:10: solver.alpha: is inf; a finite number is expected",
        ),
        (
            "agents:",
            "solver: {linear_solver: ./evil}\nagents:",
            "4:10: solver.linear_solver: is './evil'; text that matches ^[a-z][a-z0-9-]*$ is",
        ),
        (
            "agents:",
            "solver: {ipopt: {output_file: /tmp/x}}\nagents:",
            "4:18: solver.ipopt.output_file: is refused: a scene must not name files to write",
        ),
        (
            "agents:",
            "solver: {ipopt: {tol: [1]}}\nagents:",
            "4:18: solver.ipopt.tol: is a list of 1; text or a number is expected",
        ),
    ],
)
def test_key_of_the_scene(old, new, message):
    (found,) = refusals(edited(old, new))
    assert found.startswith(f"scene.yaml:{message}")


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
            "4:19: pairs[0].between[1]: is 3; an agent's id, all, or a list of ids is expected",
        ),
        (
            "{between: [sam, []], distance: 1}",
            "4:19: pairs[0].between[1]: is a list of 0; an agent's id, all, or a list of ids is "
            "expected",
        ),
        (
            "{between: [sam, ann]}",
            "4:3: pairs[0]: changes nothing; distance, grouping or collide is expected",
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
        ("{}", ["4:1: map: has none of mesh, polygon and rectangle; one is expected"]),
        (
            "{rectangle: [0, 0, 1, 1], polygon: [[0, 0], [1, 1], [1, 0]]}",
            ["4:1: map: has polygon and rectangle of mesh, polygon and rectangle; one is"],
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
            "{polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}",
            ["4:7: map.polygon: crosses or touches itself (Self-intersection[0.5 0.5]); a simple"],
        ),
        (
            "{polygon: [[0, 0], [1, 1], [0, 0]]}",
            ["4:7: map.polygon: has 2 distinct points; a ring of at least 3 is expected"],
        ),
        ("{polygon: [[0, 0], [1, 1]]}", ["4:7: map.polygon: is a list of 2; at least 3 is"]),
        (
            "{polygon: [[0, 0], [9, 0], [9, 9], [0, 9]], holes: [[[8, 8], [10, 8], [8, 10]]]}",
            ["4:50: map.holes: (Self-intersection[8 9]); holes inside the polygon, apart, are"],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{}, {rectangle: [1, 1, 0, 2]}]}",
            [
                "4:44: map.obstacles[0]: has none of rectangle, polygon and circle; one is",
                "4:49: map.obstacles[1].rectangle: reaches from xmin 1 to xmax 0; ",
            ],
        ),
        (
            "{rectangle: [0, 0, 9, 9], obstacles: [{circle: {center: [1, 1], radius: 0}}]}",
            ["4:70: map.obstacles[0].circle.radius: is 0; more than 0 is expected"],
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
    found = refusals(edited("agents:", f"map: {entry}\nagents:"), tmp_path)
    assert len(found) == len(messages)
    for message, expected in zip(found, messages, strict=True):
        assert message.startswith(f"scene.yaml:{expected}")


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
    from stplan.scene import parse_scene

    near = edited("start: [0.0, 5.0]", "start: [0.0, 0.1]")
    assert refusals(near)
    assert parse_scene(edited(*change, text=near)).name == "pair"


def test_vanishing_agents_may_share_a_goal():
    from stplan.scene import parse_scene

    shared = edited("goal: [10.0, 5.0]", "goal: [10.0, 0.0]")
    assert refusals(shared)
    scene = parse_scene(edited("agents:", "defaults: {after_arrival: vanish}\nagents:", shared))
    assert scene.agents[0].goal == scene.agents[1].goal


def test_pair_of_examples_is_a_scene():
    from stplan.scene import parse_scene

    assert [agent.id for agent in parse_scene(PAIR).agents] == ["sam", "ann"]
