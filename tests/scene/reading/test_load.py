"""From text to a complete scene: defaults, every key, names, times."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest

from stplan.maps.obstacles import CircleObstacle, PolygonObstacle
from stplan.maps.polygon import PolygonBase
from stplan.scene import Agent, load_scene, parse_scene, scene_interactions
from stplan.scene.model import (
    SeedingSettings,
    SolverSettings,
    Weights,
)
from tests.scene.samples import (
    FULL,
    TRIANGLE,
    agents_text,
    dump,
    edited,
    full_tree,
    refusal,
    scene_text,
)

ROOT = Path(__file__).parents[3]
SHIPPED = sorted((ROOT / "scenes").glob("*/*.yaml"))


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
            "clearance": 1.0,
        },
        "path": None,
        "max_speed": None,
        "max_acceleration": None,
        "start_velocity": None,
        "start_duration": 0.0,
        "moving_goal": None,
        "sight": None,
        "line_of_sight": False,
        "visits": (),
        "clearance": 0.0,
        "goal_places": (),
    }
    assert (scene.name, scene.description, scene.map, scene.pairs) == ("scene", "", None, ())
    assert (scene.time_scale, scene.horizon, scene.final_time) == (1, 20, 20)
    assert dataclasses.asdict(scene.seeding) == {
        "method": "auto",
        "layers": None,
        "margin": 1.05,
        "time_limit": 60,
        "rng_seed": 0,
        "shortcuts": True,
    }
    assert dataclasses.asdict(scene.solver) == {
        "knots": None,
        "effort": "normal",
        "starts": None,
        "mu": None,
        # Tuned by measurement.
        "mu_decay": scene.solver.mu_decay,
        "outer_iterations": 5,
        "max_iterations": 200,
        "step_tolerance": 0.01,
        "optimality_tolerance": 0.01,
        "alpha": 50,
        "clearance_model": "contacts",
        "barrier_range": None,
        "hessian": "gauss-newton",
        "linear_solver": "mumps",
        "ipopt": {},
        "alpha_rule": "half-clearance",
        "hessian_cutoff": 0.0,
        "convergence": "decrease",
        "blocks": None,
    }


def test_every_key_arrives():
    tree = full_tree()
    scene = parse_scene(dump(tree))
    for part in ("seeding", "solver"):
        assert dataclasses.asdict(getattr(scene, part)) == tree[part]
    sam, ann, cart = scene.agents
    assert dataclasses.asdict(sam.weights) == tree["defaults"]["weights"]
    for key in ("start_time", "max_time", "preferred_time", "radius", "clearance", "mass"):
        assert getattr(sam, key) == getattr(ann, key) == tree["defaults"][key]
    assert sam.waypoints == ann.waypoints == ((2, 1), (3, 1.5))
    assert cart.waypoints == ()
    assert scene.map is not None
    assert scene.map.resolution == 0.5
    assert len(scene.map.obstacles) == 3
    assert (scene.name, scene.description, scene.time_scale) == ("full-scene_2", "every key", 1.5)


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


def test_a_horizon_is_not_needed_where_every_agent_has_its_own():
    text = edited("horizon: 20.0", "defaults: {max_time: 7}")
    assert parse_scene(text).horizon == 7.0


def test_horizon_may_be_missing():
    text = "stplan: 1\nagents:\n  - {id: sam, start: [0, 0], goal: [1, 1]%s}\n"
    assert "horizon" in refusal(text % "")
    assert parse_scene(text % ", max_time: 7").horizon == 7
    path = "stplan: 1\nagents:\n  - {id: sam, path: [[0, 0, 0], [1, 1, 4]]}\n"
    assert parse_scene(path).horizon == 4
    assert parse_scene(scene_text("max_time: 30")).final_time == 30


def test_path_agents():
    agent = parse_scene(agents_text("id: sam, path: [[0, 0, 1], [2, 1, 3], [4, 0, 9]]")).agents[0]
    assert (agent.start, agent.goal, agent.start_time, agent.max_time) == ((0, 0), (4, 0), 1, 9)
    assert agent.path == ((0, 0, 1), (2, 1, 3), (4, 0, 9))


def test_what_repeats_the_path_may_stand():
    text = "id: sam, path: [[0, 0, 1], [2, 1, 3]], start: [0, 0], goal: [2, 1], start_time: 1, max_time: 3"
    assert parse_scene(agents_text(text)).agents[0].max_time == 3


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("Circle 8", "circle-8"),
        ("_x", "x"),
        ("...", "scene"),
        ("日本", "scene"),
        ("My Gap!", "my-gap"),
        ("---", "scene"),
        ("a.b", "a-b"),
        ("x" * 300, "x" * 100),
    ],
)
def test_name_from_the_file(stem, name):
    text = edited("name: pair\n", "")
    assert parse_scene(text, source=Path(f"{stem}.yaml")).name == name


def test_mesh(tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "a.obj").write_text(TRIANGLE, encoding="utf-8")
    path = tmp_path / "a.yaml"
    path.write_text(scene_text(top="map: {mesh: maps/a.obj, up: y}"), encoding="utf-8")
    base = load_scene(path).map.base
    assert (base.file.path, base.up) == (tmp_path / "maps" / "a.obj", "y")


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scene_loads(path):
    scene = load_scene(path)
    assert scene.source == path
    assert scene.locations["agents[0].id"][0] > 1
    assert load_scene(str(path)).content_hash == scene.content_hash


def test_there_are_shipped_scenes():
    assert len(SHIPPED) > 5
