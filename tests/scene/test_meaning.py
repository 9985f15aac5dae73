"""What a file means: defaults, merged agents, hashes, names, places."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.errors import SceneError
from stplan.scene import Agent, load_scene, parse_scene, scene_interactions
from stplan.scene.model import (
    CircleObstacle,
    MeshBase,
    PolygonBase,
    PolygonObstacle,
    SeedingSettings,
    SolverSettings,
    Weights,
)
from stplan.scene.reader import LARGEST_FILE
from tests.scene.examples import PAIR, edited

ROOT = Path(__file__).parents[2]
SHIPPED = sorted((ROOT / "scenes").glob("*/*.yaml"))

FULL = """\
stplan: 1
description: all kinds of keys
map:
  polygon: [[-9, -9], [20, -9], [20, 9], [-9, 9], [-9, -9]]
  holes: [[[-8, -8], [-7, -8], [-7, -7]]]
  obstacles:
    - {rectangle: [1, 6, 2, 7]}
    - {circle: {center: [4, -6], radius: 0.5}}
    - {polygon: [[5, 7], [6, 7], [6, 8]]}
  resolution: 0.5
horizon: 20
time_scale: 2
defaults:
  mass: 80
  start_time: 1
  waypoints: [[3, 1]]
  weights: {acceleration: 0.5, regularity: 7, wall: 2}
agents:
  - id: sam
    start: [0, 0]
    goal: [10, 4]
    radius: 0.25
    max_time: 15
    preferred_time: 12
    weights: {arrival: 3, regularity: auto, wall: 0}
  - {id: ann, start: [0, 3], goal: [10, 1], start_time: 0, waypoints: [], after_arrival: vanish}
  - {id: cart, path: [[0, -5, 2], [5, -5, 4], [10, -5, 9]], radius: 1}
pairs:
  - {between: [sam, all], distance: 2.5}
  - {between: [[ann, cart], sam], grouping: 5, distance: 1.5}
  - {between: [ann, cart], collide: no}
seeding: {method: search, layers: 20, margin: 1.2, time_limit: 5, rng_seed: 7}
solver: {knots: 30, barrier_range: .inf, ipopt: {tol: 1e-6, print_timing_statistics: yes}}
"""


def test_everything_is_read():
    scene = parse_scene(FULL, source=Path("some/Büro Raum_2.yaml"))
    assert scene.name == "b-ro-raum_2"
    assert scene.horizon == 20.0
    assert scene.time_scale == 2.0
    assert scene.map is not None
    assert scene.map.base == PolygonBase(
        ((-9.0, -9.0), (20.0, -9.0), (20.0, 9.0), (-9.0, 9.0)),
        (((-8.0, -8.0), (-7.0, -8.0), (-7.0, -7.0)),),
    )
    assert scene.map.obstacles == (
        PolygonObstacle(((1.0, 6.0), (2.0, 6.0), (2.0, 7.0), (1.0, 7.0))),
        CircleObstacle((4.0, -6.0), 0.5),
        PolygonObstacle(((5.0, 7.0), (6.0, 7.0), (6.0, 8.0))),
    )
    assert scene.map.resolution == 0.5
    sam, ann, cart = scene.agents
    assert sam == Agent(
        id="sam",
        start=(0.0, 0.0),
        goal=(10.0, 4.0),
        start_time=1.0,
        max_time=15.0,
        preferred_time=12.0,
        radius=0.25,
        mass=80.0,
        after_arrival="stay",
        waypoints=((3.0, 1.0),),
        weights=Weights(1.0, 0.5, 3.0, None, 1.0, 0.0),
    )
    assert ann.weights == Weights(acceleration=0.5, regularity=7.0, wall=2.0)
    assert (ann.start_time, ann.max_time, ann.waypoints) == (0.0, 20.0, ())
    assert (ann.radius, ann.after_arrival) == (0.3, "vanish")
    assert cart.path == ((0.0, -5.0, 2.0), (5.0, -5.0, 4.0), (10.0, -5.0, 9.0))
    assert (cart.start, cart.goal) == ((0.0, -5.0), (10.0, -5.0))
    assert (cart.start_time, cart.max_time, cart.waypoints) == (2.0, 9.0, ())
    assert scene.seeding == SeedingSettings("search", 20, 1.2, 5.0, 7)
    assert scene.solver == SolverSettings(
        knots=30,
        barrier_range=float("inf"),
        ipopt={"tol": 1e-6, "print_timing_statistics": "yes"},
    )
    pairs = scene_interactions(scene)
    assert pairs.distance[0, 1:].tolist() == [1.5, 1.5]
    assert pairs.distance[1, 2] == 1.3
    assert pairs.grouping.tolist() == [[0, 5, 5], [5, 0, 0], [5, 0, 0]]
    assert pairs.collides.tolist() == [
        [False, True, True],
        [True, False, False],
        [True, False, False],
    ]


def test_what_is_left_out_has_the_defaults_of_the_model():
    scene = parse_scene("stplan: 1\nhorizon: 9\nagents: [{id: a, start: [0, 0], goal: [1, 1]}]")
    assert scene.seeding == SeedingSettings()
    assert scene.solver == SolverSettings()
    assert scene.agents[0].weights == Weights()
    assert (scene.name, scene.map, scene.pairs) == ("scene", None, ())


def test_values_are_floats():
    scene = parse_scene(FULL)
    for agent in scene.agents:
        values = [*agent.start, *agent.goal, agent.start_time, agent.max_time, agent.mass]
        values += [value for value in dataclasses.astuple(agent.weights) if value is not None]
        assert all(isinstance(value, float) for value in values)


def test_a_horizon_is_not_needed_where_every_agent_has_its_own():
    text = edited("horizon: 20.0", "defaults: {max_time: 7}")
    assert parse_scene(text).horizon == 7.0


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("Circle 8", "circle-8"),
        ("_x", "x"),
        ("...", "scene"),
        ("日本", "scene"),
        ("a.b", "a-b"),
        ("x" * 300, "x" * 100),
    ],
)
def test_name_from_the_file(stem, name):
    text = edited("name: pair\n", "")
    assert parse_scene(text, source=Path(f"{stem}.yaml")).name == name


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scene_loads(path):
    scene = load_scene(path)
    assert scene.source == path
    assert scene.locations["agents[0].id"][0] > 1
    assert load_scene(str(path)).content_hash == scene.content_hash


def test_there_are_shipped_scenes():
    assert len(SHIPPED) > 5


# --- files -----------------------------------------------------------------------------------------


def test_file_with_byte_order_mark_and_carriage_returns(tmp_path):
    path = tmp_path / "pair.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + PAIR.replace("\n", "\r\n").encode())
    scene = load_scene(path)
    assert scene.locations["agents[1].id"] == (9, 5)
    assert scene.content_hash == parse_scene(PAIR).content_hash


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", ":1:1: the file is empty; a scene is expected"),
        (
            b"stplan: 1\nname: \xff",
            ":2:7: the byte 0xff is not UTF-8; a YAML text is expected",
        ),
        (b"a" * (LARGEST_FILE + 1), ":1:1: the file is larger than 16 MiB"),
        (None, ": no such scene file"),
    ],
)
def test_file_refused(tmp_path, content, message):
    path = tmp_path / "s.yaml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    assert str(refused.value) == f"{path}{message}"


def test_a_folder_is_no_scene(tmp_path):
    with pytest.raises(SceneError, match="cannot be read: Is a directory"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene("a\0b")


# --- content hash ----------------------------------------------------------------------------------


def mesh_scene(folder: Path, mesh: str = "map.obj") -> str:
    (folder / mesh).write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n")
    return edited("agents:", f"map: {{mesh: {mesh}}}\nagents:")


def shuffled(value, draw):
    if isinstance(value, dict):
        keys = draw(st.permutations(list(value)))
        return {key: shuffled(value[key], draw) for key in keys}
    if isinstance(value, list):
        return [shuffled(entry, draw) for entry in value]
    return value


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.data())
def test_hash_ignores_order_of_keys_formatting_and_comments(data):
    tree = shuffled(yaml.safe_load(FULL.replace("1e-6", "1.0e-6")), data.draw)
    flow = data.draw(st.booleans())
    text = "# a comment\n" + yaml.safe_dump(tree, sort_keys=False, default_flow_style=flow)
    assert parse_scene(text).content_hash == parse_scene(FULL).content_hash


def test_hash_ignores_where_the_scene_lies(tmp_path):
    (tmp_path / "b").mkdir()
    here = parse_scene(mesh_scene(tmp_path), directory=tmp_path)
    there = parse_scene(mesh_scene(tmp_path / "b", "other.obj"), directory=tmp_path / "b")
    assert here.content_hash == there.content_hash
    assert len(here.content_hash) == 64
    assert isinstance(here.map.base, MeshBase)
    assert here.map.base.path.is_file()


def test_hash_knows_the_bytes_of_the_mesh(tmp_path):
    before = parse_scene(mesh_scene(tmp_path), directory=tmp_path).content_hash
    text = mesh_scene(tmp_path)
    (tmp_path / "map.obj").write_text("v 0 0 0\nv 8 0 0\nv 0 9 0\nf 1 2 3\n")
    assert parse_scene(text, directory=tmp_path).content_hash != before


@pytest.mark.parametrize(
    "override",
    [
        "agents.sam.radius=0.26",
        "agents.sam.weights.wall=1",
        "horizon=21",
        "solver.mu_decay=0.7",
        "seeding.rng_seed=8",
        "solver.ipopt.tol=1e-5",
        "pairs[2].collide=true",
        "map.resolution=0.6",
        "solver.barrier_range=1",
    ],
)
def test_hash_knows_every_value(override):
    assert parse_scene(FULL, overrides=[override]).content_hash != parse_scene(FULL).content_hash


def test_defaults_written_out_are_the_same_scene():
    text = edited("radius: 0.3\n", "start_time: 0\n    mass: 1\n    weights: {regularity: auto}\n")
    assert parse_scene(text).content_hash == parse_scene(PAIR).content_hash


# --- pace ------------------------------------------------------------------------------------------


def crowd(count: int) -> str:
    return "stplan: 1\nhorizon: 20\nagents:\n" + "".join(
        f"  - id: a{k}\n    start: [{k}.0, 0.0]\n    goal: [{k}.0, 5.0]\n    radius: 0.2\n"
        "    weights: {kinetic: 1.0, acceleration: 0, arrival: 0, collision: 1, wall: 1}\n"
        for k in range(count)
    )


def test_a_thousand_agents_are_read_in_time():
    text = crowd(1000)
    began = time.perf_counter()
    scene = parse_scene(text)
    assert time.perf_counter() - began < 3.0
    assert len(scene.agents) == 1000


def test_overlaps_are_found_in_every_block_of_rows():
    text = crowd(1200)
    for old, new in (("a700", "a699"), ("a1199", "a3")):
        k, other = old[1:], new[1:]
        text = text.replace(f"start: [{k}.0, 0.0]", f"start: [{other}.0, 0.1]")
    with pytest.raises(SceneError) as refused:
        parse_scene(text)
    assert [message.split(": ")[1:3] for message in refused.value.messages] == [
        [
            f"agents[{k}].start",
            f"is 0.1 m from the start of '{other}', and both start at once; "
            "more than 0.4 m is expected of agents that collide",
        ]
        for k, other in ((700, "a699"), (1199, "a3"))
    ]


def test_too_many_agents():
    text = "stplan: 1\nhorizon: 9\nagents: [" + "{id: a}, " * 10_001 + "]"
    with pytest.raises(SceneError, match=r"agents: is a list of 10001; at most 10000 is expected"):
        parse_scene(text)


def test_overlaps_agree_with_the_arrays_of_pairs():
    """The blocks of rows decide as `scene_interactions` does, rule by rule."""
    generator = np.random.default_rng(3)
    for _ in range(20):
        places = generator.uniform(0, 3, (6, 2)).round(2)
        rules = "".join(
            f"  - {{between: [{generator.choice(['a0', 'a1', 'all', '[a2, a3]'])}, "
            f"{generator.choice(['a4', '[a1, a5]', 'all'])}], {what}}}\n"
            for what in ("distance: 0.2", "collide: false", "distance: 1.5", "collide: true")
            if generator.random() < 0.7
        )
        agents = "".join(
            f"  - {{id: a{k}, start: [{x}, {y}], goal: [{9 * k}, 50], radius: 0.3}}\n"
            for k, (x, y) in enumerate(places)
        )
        apart = "".join(
            f"  - {{id: a{k}, start: [{9 * k}, 0], goal: [{9 * k}, 50], radius: 0.3}}\n"
            for k in range(6)
        )
        head = "stplan: 1\nhorizon: 9\n" + (f"pairs:\n{rules}" if rules else "")
        pairs = scene_interactions(parse_scene(f"{head}agents:\n{apart}"))
        gap = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
        near = np.tril(pairs.collides & (gap <= pairs.distance), -1).any(axis=1)
        try:
            parse_scene(f"{head}agents:\n{agents}")
            found = []
        except SceneError as error:
            found = [message.split(": ")[1] for message in error.messages]
        assert found == [f"agents[{k}].start" for k in np.nonzero(near)[0]]


def test_reading_a_scene_needs_no_heavy_imports():
    code = (
        "import sys, stplan.scene; "
        "print([name for name in ('numba', 'scipy', 'shapely', 'trimesh') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
