"""Every refusal says where, what is wrong and what is expected."""

from __future__ import annotations

import pytest

from tests.scene.samples import agents_text, edited, refusal, refusals, scene_text

RADIUS = "    radius: 0.3\n"
BAD_NAME = "a name without white space and without any of ,;=\"'`[]{}\\ (not %s) is expected"

FAULTS = [
    ("after_arrival: stayy", "", "agents[0].after_arrival", "did you mean 'stay'?"),
    ("weights: {kinetc: 1}", "", "agents[0].weights.kinetc", "did you mean 'kinetic'?"),
    ("start_velocity: 3", "", "agents[0].start_velocity", "a velocity [vx, vy] in m/s is expected"),
    (
        "max_speed: 1, start_velocity: [0.8, 0.8]",
        "",
        "agents[0].start_velocity",
        "is 1.131 m/s; no more than max_speed 1 m/s is expected",
    ),
    ("start_duration: 1", "", "agents[0].start_duration", "belongs to a start_velocity"),
    (
        "start_velocity: [0, 0], start_duration: 30",
        "",
        "agents[0].start_duration",
        "is 30 s; less than the 20 s there are is expected",
    ),
    ("waypoints: 3", "", "agents[0].waypoints", "a list"),
    ("waypoints: [[1]]", "", "agents[0].waypoints[0]", "expected"),
    ("waypoints: [[1, a]]", "", "agents[0].waypoints[0][1]", "a number is expected"),
    (
        "max_time: 5, preferred_time: 6",
        "",
        "agents[0].preferred_time",
        "no later than max_time 5 s",
    ),
    ("", "sovler: {}", "sovler", "did you mean 'solver'?"),
    ("", "defaults: {id: a}", "defaults.id", "key"),
    ("", "solver: {mu: aut}", "solver.mu", "auto"),
    ("", "solver: {mu: .nan}", "solver.mu", "is expected"),
    (
        "",
        "solver: {outer_iterations: 5.0}",
        "solver.outer_iterations",
        "a whole number is expected",
    ),
    ("", "solver: {hessian: exactt}", "solver.hessian", "did you mean 'exact'?"),
    ("", "solver: {ipopt: {tol: .nan}}", "solver.ipopt.tol", "expected"),
    ("", "seeding: {method: serach}", "seeding.method", "did you mean 'search'?"),
    ("", "seeding: {margin: 11}", "seeding.margin", "at most 10 is expected"),
    ("", "pairs: [{between: [sam, ann], collide: 1}]", "pairs[0].collide", "true or false"),
    ("", "map: {rectangle: [0, 0, 0, 1]}", "map.rectangle", "xmin < xmax is expected"),
]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("radus: 0.3", "8:5: agents[0].radus: unknown key; did you mean 'radius'?"),
        ("Radius: 0.3", "8:5: agents[0].Radius: unknown key; did you mean 'radius'?"),
        (
            "colour: red",
            "8:5: agents[0].colour: unknown key; start_time, max_time, preferred_time, radius, clearance, "
            "mass, after_arrival, max_speed, max_acceleration, start_velocity, start_duration, waypoints, "
            "perception, weights, id, start, goal and path are known",
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


@pytest.mark.parametrize(
    ("more", "path"),
    [
        ("path: [[0, 0, 1], [2, 1, 1]]", "path[1][2]"),
        ("path: [[0, 0, 1], [2, 1, 0]]", "path[1][2]"),
        ("path: [[0, 0, 1], [2, 1, 3]], start: [1, 0]", "start"),
        ("path: [[0, 0, 1], [2, 1, 3]], goal: [1, 0]", "goal"),
        ("path: [[0, 0, 1], [2, 1, 3]], start_time: 0", "start_time"),
        ("path: [[0, 0, 1], [2, 1, 3]], max_time: 2", "max_time"),
        ("path: [[0, 0, 1], [2, 1, 3]], waypoints: [[1, 1]]", "waypoints"),
        ("path: [[0, 0], [2, 1]]", "path[0]"),
    ],
)
def test_path_faults(more, path):
    messages = refusals(agents_text(f"id: sam, {more}"))
    assert f"agents[0].{path}: " in messages[0]


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
    ("own", "top", "path", "sentence"), FAULTS, ids=[f[0] or f[1] for f in FAULTS]
)
def test_fault(own, top, path, sentence):
    message = refusal(scene_text(own, top))
    line = 6 if top else 4
    assert message.startswith(f"scene.yaml:{line}:")
    assert f": {path}: " in message
    assert sentence in message
    # Sentences for people.
    for ugly in ("None", "True", "False", "1 entries", "0.0 ", "pydantic", "Input should"):
        assert ugly not in message


@pytest.mark.parametrize("version", ["2", "'1'", "true", "1.0", "[1]", "0"])
def test_other_versions(version):
    message = refusal(scene_text().replace("stplan: 1", f"stplan: {version}"))
    assert message.startswith("scene.yaml:1:1: stplan: ")
    assert "did you mean '1'" not in message


def test_missing_keys():
    messages = refusals("horizon: 3\n")
    assert len(messages) == 2
    assert any("stplan: is missing" in message for message in messages)
    assert any("agents: is missing" in message for message in messages)
    assert "agents[0].id: is missing" in refusal(agents_text("start: [0, 0], goal: [1, 1]"))
    assert len(refusals(agents_text("id: sam"))) == 2
