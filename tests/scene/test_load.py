"""From text to a complete scene: defaults, faults with their places, rules between keys, the hash."""

from __future__ import annotations

import copy
import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.errors import SceneError
from stplan.scene import load_scene, parse_scene
from tests.scene.samples import agents_text as _agents
from tests.scene.samples import dump, full_tree, places, refusal, refusals, scene_text

TRIANGLE = "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n"


# Defaults and values


def test_defaults():
    scene = parse_scene(scene_text())
    agent = scene.agents[0]
    assert dataclasses.asdict(agent) == {
        "id": "sam",
        "start": (0, 0),
        "goal": (5, 0),
        "start_time": 0,
        "max_time": 20,
        "preferred_time": None,
        "radius": 0.3,
        "mass": 1,
        "after_arrival": "stay",
        "waypoints": (),
        "weights": {
            "kinetic": 1,
            "acceleration": 0,
            "arrival": 0,
            "regularity": None,
            "collision": 1,
            "wall": 1,
        },
        "path": None,
        "max_speed": None,
        "max_acceleration": None,
        "visits": (),
    }
    assert (scene.name, scene.description, scene.map, scene.pairs) == ("scene", "", None, ())
    assert (scene.time_scale, scene.horizon, scene.final_time) == (1, 20, 20)
    assert dataclasses.asdict(scene.seeding) == {
        "method": "auto",
        "layers": None,
        "margin": 1.05,
        "time_limit": 60,
        "rng_seed": 0,
    }
    assert dataclasses.asdict(scene.solver) == {
        "knots": None,
        "starts": None,
        "mu": None,
        # Tuned by measurement.
        "mu_decay": scene.solver.mu_decay,
        "outer_iterations": 5,
        "max_iterations": 100,
        "step_tolerance": 0.01,
        "optimality_tolerance": 0.01,
        "alpha": 50,
        "clearance_model": "contacts",
        "barrier_range": None,
        "hessian": "gauss-newton",
        "linear_solver": "mumps",
        "ipopt": {},
    }


def test_every_key_arrives():
    tree = full_tree()
    scene = parse_scene(dump(tree))
    for part in ("seeding", "solver"):
        assert dataclasses.asdict(getattr(scene, part)) == tree[part]
    sam, ann, cart = scene.agents
    assert dataclasses.asdict(sam.weights) == tree["defaults"]["weights"]
    for key in ("start_time", "max_time", "preferred_time", "radius", "mass", "after_arrival"):
        assert getattr(sam, key) == getattr(ann, key) == tree["defaults"][key]
    assert sam.waypoints == ann.waypoints == ((2, 1), (3, 1.5))
    assert cart.waypoints == ()
    assert scene.map is not None
    assert scene.map.resolution == 0.5
    assert len(scene.map.obstacles) == 3
    assert (scene.name, scene.description, scene.time_scale) == ("full-scene_2", "every key", 1.5)


def test_auto_is_the_default():
    top = "seeding: {layers: auto}\nsolver: {knots: auto, mu: auto, barrier_range: auto}"
    scene = parse_scene(scene_text("weights: {regularity: auto}", top))
    plain = parse_scene(scene_text())
    assert (scene.seeding, scene.solver, scene.agents) == (
        plain.seeding,
        plain.solver,
        plain.agents,
    )


@pytest.mark.parametrize("written", ["inf", ".inf"])
def test_unbounded_barrier(written):
    scene = parse_scene(scene_text(top=f"solver: {{barrier_range: {written}}}"))
    assert scene.solver.barrier_range == math.inf


def test_weights_are_merged_one_by_one():
    top = "defaults: {weights: {kinetic: 2, wall: 3, regularity: 4}}"
    weights = parse_scene(scene_text("weights: {wall: 0, regularity: auto}", top)).agents[0].weights
    assert (weights.kinetic, weights.wall, weights.regularity) == (2, 0, None)


def test_ipopt_words():
    scene = parse_scene(scene_text(top="solver: {ipopt: {mehrotra_algorithm: yes, tol: 1e-3}}"))
    assert dict(scene.solver.ipopt) == {"mehrotra_algorithm": "yes", "tol": 1e-3}


# Faults: place, path, sentence

FAULTS = [
    ("radius: 0", "", "agents[0].radius", "is 0; more than 0 is expected"),
    ("mass: -1", "", "agents[0].mass", "is -1; more than 0 is expected"),
    ("weights: {wall: -1}", "", "agents[0].weights.wall", "at least 0 is expected"),
    ("after_arrival: stayy", "", "agents[0].after_arrival", "did you mean 'stay'?"),
    ("radus: 1", "", "agents[0].radus", "did you mean 'radius'?"),
    ("weights: {kinetc: 1}", "", "agents[0].weights.kinetc", "did you mean 'kinetic'?"),
    ("waypoints: 3", "", "agents[0].waypoints", "a list"),
    ("waypoints: [[1]]", "", "agents[0].waypoints[0]", "expected"),
    ("waypoints: [[1, a]]", "", "agents[0].waypoints[0][1]", "a number is expected"),
    ("path: [[0, 0, 0]]", "", "agents[0].path", "at least 2"),
    ("start_time: 30", "", "agents[0].start_time", "less than the horizon 20 s"),
    (
        "max_time: 5, preferred_time: 6",
        "",
        "agents[0].preferred_time",
        "no later than max_time 5 s",
    ),
    ("preferred_time: 0", "", "agents[0].preferred_time", "after start_time"),
    ("weights: {arrival: 1}", "", "agents[0].weights.arrival", "preferred_time"),
    ("weights: {regularity: atuo}", "", "agents[0].weights.regularity", "auto"),
    ("", "sovler: {}", "sovler", "did you mean 'solver'?"),
    ("", "time_scale: 0", "time_scale", "more than 0 is expected"),
    ("", "defaults: {id: a}", "defaults.id", "key"),
    ("", "solver: {mu: aut}", "solver.mu", "auto"),
    ("", "solver: {mu: .nan}", "solver.mu", "is expected"),
    ("", "solver: {knots: 2}", "solver.knots", "at least 3 is expected"),
    (
        "",
        "solver: {outer_iterations: 5.0}",
        "solver.outer_iterations",
        "a whole number is expected",
    ),
    ("", "solver: {hessian: exactt}", "solver.hessian", "did you mean 'exact'?"),
    ("", "solver: {barrier_range: .nan}", "solver.barrier_range", "is expected"),
    ("", "solver: {ipopt: {tol: [1]}}", "solver.ipopt.tol", "expected"),
    ("", "solver: {ipopt: {tol: .nan}}", "solver.ipopt.tol", "expected"),
    ("", "seeding: {method: serach}", "seeding.method", "did you mean 'search'?"),
    ("", "seeding: {margin: 11}", "seeding.margin", "at most 10 is expected"),
    (
        "",
        "pairs: [{between: [sam, an], collide: false}]",
        "pairs[0].between[1]",
        "did you mean 'ann'?",
    ),
    ("", "pairs: [{between: [sam], collide: false}]", "pairs[0].between", "2"),
    ("", "pairs: [{between: [sam, 3], collide: false}]", "pairs[0].between[1]", "expected"),
    ("", "pairs: [{between: [sam, ann], collide: 1}]", "pairs[0].collide", "true or false"),
    ("", "pairs: [{between: [sam, ann]}]", "pairs[0]", "distance, grouping or collide is expected"),
    ("", "map: {}", "map", "mesh, polygon and rectangle; one is expected"),
    ("", "map: {rectangle: [0, 0, 0, 1]}", "map.rectangle", "xmin < xmax is expected"),
    ("", "map: {rectangle: [0, 0, 1]}", "map.rectangle", "expected"),
    (
        "",
        "map: {polygon: [[0, 0], [9, 9], [9, 0], [0, 9]]}",
        "map.polygon",
        "a simple ring is expected",
    ),
    ("", "map: {polygon: [[0, 0], [9, 9]]}", "map.polygon", "at least 3"),
    ("", "map: {rectangle: [0, 0, 9, 9], up: x}", "map.up", "belongs to a mesh"),
    ("", "map: {rectangle: [0, 0, 9, 9], holes: []}", "map.holes", "polygon"),
    (
        "",
        "map: {rectangle: [0, 0, 9, 9], obstacles: [{}]}",
        "map.obstacles[0]",
        "rectangle, polygon and circle; one is expected",
    ),
]


@pytest.mark.parametrize(
    ("own", "top", "path", "sentence"), FAULTS, ids=[f[0] or f[1] for f in FAULTS]
)
def test_fault(own, top, path, sentence):
    message = refusal(scene_text(own, top))
    line = 6 if top else 4
    assert message.startswith(f"scene:{line}:")
    assert f": {path}: " in message
    assert sentence in message
    # Sentences for people.
    for ugly in ("None", "True", "False", "1 entries", "0.0 ", "pydantic", "Input should"):
        assert ugly not in message


def test_place_of_the_key():
    text = "stplan: 1\nhorizon: 9\nagents:\n  - id: sam\n    start: [0, 0]\n    goal: [1, 1]\n    radius: x\n"
    assert refusal(text).startswith("scene:7:5: agents[0].radius: is 'x'; a number is expected")


@pytest.mark.parametrize("version", ["2", "'1'", "true", "1.0", "[1]", "0"])
def test_other_versions(version):
    message = refusal(scene_text().replace("stplan: 1", f"stplan: {version}"))
    assert message.startswith("scene:1:1: stplan: ")
    assert "did you mean '1'" not in message


def test_missing_keys():
    messages = refusals("horizon: 3\n")
    assert len(messages) == 2
    assert any("stplan: is missing" in message for message in messages)
    assert any("agents: is missing" in message for message in messages)
    assert "agents[0].id: is missing" in refusal(_agents("start: [0, 0], goal: [1, 1]"))
    assert len(refusals(_agents("id: sam"))) == 2


def test_no_agents():
    assert "agents" in refusal("stplan: 1\nhorizon: 3\nagents: []\n")


def test_all_faults_at_once_in_order_of_the_file():
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
        + _agents(
            "id: sam, start: [0, 0], goal: [1, 1], preferred_time: 40", "id: sam, start: [3, 3]"
        )
        + "map: {rectangle: [1, 1, 0, 0]}\n"
    )
    # Both sides of the rectangle are the wrong way round, the second agent has no goal and a known id.
    assert len(rules) == 6
    assert places(rules) == sorted(places(rules))


def test_file_heads_the_message(tmp_path):
    path = tmp_path / "my scene.yaml"
    path.write_text(scene_text("radius: 0"), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert caught.value.messages[0].startswith(f"{path}:4:")
    assert caught.value.exit_status == 2


# Names, ids, meshes


@pytest.mark.parametrize(
    "name", ["../x", "/etc", "a/b", "A", "", ".", "-a", "'a\\n'", '"a\\n"', "a b", "3"]
)
def test_names_that_are_no_folder(name):
    assert "name: " in refusal(scene_text(top=f"name: {name or repr('')}"))


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("gap.yaml", "gap"),
        ("My Gap!.yaml", "my-gap"),
        ("---.yaml", "scene"),
        ("日本.yaml", "scene"),
    ],
)
def test_name_from_the_file(tmp_path, file, name):
    (tmp_path / file).write_text(scene_text(), encoding="utf-8")
    assert load_scene(tmp_path / file).name == name


@pytest.mark.parametrize("name", ["all", "''", "'a b'", "'a,b'", '"a\\tb"', '"a\\0"', "3", "no"])
def test_ids(name):
    messages = refusals(_agents(f"id: {name}, start: [0, 0], goal: [1, 1]"))
    assert "agents[0].id: " in messages[0]


def test_duplicate_ids():
    message = refusal(_agents(*["id: sam, start: [0, 0], goal: [1, 1]"] * 2))
    assert message.startswith("scene:5:6: agents[1].id: ")
    assert "sam" in message


def test_mesh(tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "a.obj").write_text(TRIANGLE, encoding="utf-8")
    path = tmp_path / "a.yaml"
    path.write_text(scene_text(top="map: {mesh: maps/a.obj, up: y}"), encoding="utf-8")
    base = load_scene(path).map.base
    assert (base.path, base.up) == (tmp_path / "maps" / "a.obj", "y")


@pytest.mark.parametrize(
    "mesh", ["absent.obj", "''", '"a\\0b.obj"', "maps", "a.txt", "a", "../absent.obj"]
)
def test_meshes_that_are_none(tmp_path, mesh):
    (tmp_path / "maps").mkdir()
    for file in ("a.txt", "a"):
        (tmp_path / file).write_text(TRIANGLE, encoding="utf-8")
    message = refusal(scene_text(top=f"map: {{mesh: {mesh}}}"), directory=tmp_path)
    assert "map.mesh: " in message


# Times and paths


def test_horizon_may_be_missing():
    text = "stplan: 1\nagents:\n  - {id: sam, start: [0, 0], goal: [1, 1]%s}\n"
    assert "horizon" in refusal(text % "")
    assert parse_scene(text % ", max_time: 7").horizon == 7
    path = "stplan: 1\nagents:\n  - {id: sam, path: [[0, 0, 0], [1, 1, 4]]}\n"
    assert parse_scene(path).horizon == 4
    assert parse_scene(scene_text("max_time: 30")).final_time == 30


def test_path_agents():
    agent = parse_scene(_agents("id: sam, path: [[0, 0, 1], [2, 1, 3], [4, 0, 9]]")).agents[0]
    assert (agent.start, agent.goal, agent.start_time, agent.max_time) == ((0, 0), (4, 0), 1, 9)
    assert agent.path == ((0, 0, 1), (2, 1, 3), (4, 0, 9))


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
    messages = refusals(_agents(f"id: sam, {more}"))
    assert f"agents[0].{path}: " in messages[0]


def test_what_repeats_the_path_may_stand():
    text = "id: sam, path: [[0, 0, 1], [2, 1, 3]], start: [0, 0], goal: [2, 1], start_time: 1, max_time: 3"
    assert parse_scene(_agents(text)).agents[0].max_time == 3


# Size and noise


def test_thousand_agents():
    agents = (f"id: a{k}, start: [0, {k}], goal: [9, {k}]" for k in range(1000))
    assert len(parse_scene(_agents(*agents)).agents) == 1000


def test_a_crowd_on_one_spot_is_told_briefly():
    agents = (f"id: a{k}, start: [0, 0], goal: [9, {k}]" for k in range(300))
    assert len(refusals(_agents(*agents))) < 300


def _accepted_or_refused(text):
    messages = None
    try:
        scene = parse_scene(text)
    except SceneError as error:
        messages = error.messages
    if messages is None:
        assert scene.content_hash
    else:
        assert places(messages)


VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["auto", "inf", "all", "sam", "stay", 0, -1, 10**400, 1e308, [], {}, [[]]]),
    st.lists(st.floats(), max_size=4),
    st.dictionaries(st.sampled_from(["id", "kinetic", "radius", "x"]), st.integers(), max_size=2),
)


def _spots(tree, spot=()):
    if isinstance(tree, dict | list):
        for key, inner in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield (*spot, key)
            yield from _spots(inner, (*spot, key))


SPOTS = sorted(_spots(full_tree()), key=repr)


@settings(derandomize=True, deadline=None, max_examples=150)
@given(st.lists(st.tuples(st.sampled_from(SPOTS), st.sampled_from("srd"), VALUES), max_size=3))
def test_mutations_are_accepted_or_refused(mutations):
    tree = full_tree()
    for spot, kind, value in mutations:
        at = tree
        try:
            for step in spot[:-1]:
                at = at[step]
            if kind == "d":
                del at[spot[-1]]
            elif kind == "r" and isinstance(at, dict):
                at[f"{spot[-1]}x"] = at.pop(spot[-1])
            else:
                at[spot[-1]] = copy.deepcopy(value)
        except (KeyError, IndexError, TypeError):
            continue
    _accepted_or_refused(dump(tree))


@settings(derandomize=True, deadline=None, max_examples=100)
@given(st.text(max_size=60), st.integers(0, 400))
def test_noise_in_the_text_is_accepted_or_refused(noise, position):
    text = scene_text(top="pairs: [{between: [sam, all], distance: 1.0}]")
    _accepted_or_refused(text[:position] + noise + text[position:])
