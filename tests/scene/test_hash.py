"""The hash of a scene: of its meaning, not of how it is written."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.maps.mesh.base import MeshBase
from stplan.scene import load_scene, parse_scene
from tests.scene.samples import FULL, PAIR, TRIANGLE, dump, edited, full_tree, scene_text


def mesh_scene(folder: Path, mesh: str = "map.obj") -> str:
    (folder / mesh).write_text(TRIANGLE)
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


def test_hash_ignores_the_name_of_the_file(tmp_path):
    hashes = set()
    for name in ("a.yaml", "b.yaml"):
        (tmp_path / name).write_text(scene_text(), encoding="utf-8")
        hashes.add(load_scene(tmp_path / name).content_hash)
    assert len(hashes) == 1


def test_hash_ignores_where_the_scene_lies(tmp_path):
    (tmp_path / "b").mkdir()
    here = parse_scene(mesh_scene(tmp_path), directory=tmp_path)
    there = parse_scene(mesh_scene(tmp_path / "b", "other.obj"), directory=tmp_path / "b")
    assert here.content_hash == there.content_hash
    assert len(here.content_hash) == 64
    assert isinstance(here.map.base, MeshBase)
    assert here.map.base.file.path.is_file()


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


@pytest.mark.parametrize(
    "override",
    [
        "horizon=21",
        "agents[0].goal[0]=5.1",
        "solver.mu=0.2",
        "pairs=[]",
        "agents.sam.after_arrival=stay",
    ],
)
def test_hash_changes_with_the_meaning(override):
    text = dump(full_tree())
    assert parse_scene(text, overrides=[override]).content_hash != parse_scene(text).content_hash


def test_defaults_written_out_are_the_same_scene():
    text = edited("radius: 0.3\n", "start_time: 0\n    mass: 1\n    weights: {regularity: auto}\n")
    assert parse_scene(text).content_hash == parse_scene(PAIR).content_hash


def test_hash_sees_defaults_written_out():
    written = scene_text("radius: 0.3, weights: {kinetic: 1}", "solver: {alpha: 50.0}")
    assert parse_scene(written).content_hash == parse_scene(scene_text()).content_hash


def test_hashes_stay_from_version_to_version(tmp_path):
    """Runs are known again by them; new keys at their default change nothing.

    The metric that was the default once has to be stated.
    """
    mesh = mesh_scene(tmp_path).replace(".obj}", ".obj, resolution: 2}")
    found = [
        parse_scene(text, directory=tmp_path).content_hash
        for text in (f"time_scale: 1\n{PAIR}", FULL, f"time_scale: 1\n{mesh}")
    ]
    assert found == [
        "d7ae5bd5c7222e548415dcc1a23e37844ac9f5a7a949afece97c730f2dd59f2f",
        "56abf34bfa1595b850b4966beb9e96681225908891533a3afd69629f45aa9be1",
        "a4cb92de5dcf5149eb91c3ccfccf5a8f984087b6eccc4d55c23ab3778fea7dd2",
    ]
