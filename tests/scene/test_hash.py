"""The hash of a scene: of its meaning, not of how it is written."""

from __future__ import annotations

import pytest
import yaml

from stplan.scene import load_scene, parse_scene
from tests.scene.samples import dump, full_tree, scene_text

TRIANGLE = "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n"


def _hash(tree):
    return parse_scene(dump(tree)).content_hash


def _reversed(tree):
    if isinstance(tree, dict):
        return {key: _reversed(tree[key]) for key in reversed(tree)}
    return [_reversed(entry) for entry in tree] if isinstance(tree, list) else tree


def test_hash_is_of_the_meaning(tmp_path):
    tree = full_tree()
    expected = _hash(tree)
    assert len(expected) == 64
    assert _hash(_reversed(tree)) == expected
    assert parse_scene(
        "# a comment\n" + yaml.safe_dump(tree, default_flow_style=True)
    ).content_hash == (expected)
    hashes = set()
    for name in ("a.yaml", "b.yaml"):
        (tmp_path / name).write_text(scene_text(), encoding="utf-8")
        hashes.add(load_scene(tmp_path / name).content_hash)
    assert len(hashes) == 1


def test_hash_sees_defaults_written_out():
    written = scene_text("radius: 0.3, weights: {kinetic: 1}", "solver: {alpha: 50.0}")
    assert parse_scene(written).content_hash == parse_scene(scene_text()).content_hash


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


def test_hash_follows_the_mesh(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE, encoding="utf-8")
    (tmp_path / "b.obj").write_text(TRIANGLE, encoding="utf-8")
    a, b = (
        parse_scene(scene_text(top=f"map: {{mesh: {mesh}}}"), directory=tmp_path).content_hash
        for mesh in ("a.obj", "b.obj")
    )
    assert a == b
    (tmp_path / "a.obj").write_text(TRIANGLE + "# more\n", encoding="utf-8")
    text = scene_text(top="map: {mesh: a.obj}")
    assert parse_scene(text, directory=tmp_path).content_hash != a
