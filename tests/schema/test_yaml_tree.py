"""What YAML may hold in a scene: kinds of values, harm refused, places of the faults."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from stplan.scene import parse_scene
from stplan.schema.yaml_nodes import DEEPEST
from stplan.schema.yaml_tree import read_tree
from tests.scene.samples import places, refusal, refusals, scene_text


@pytest.mark.parametrize("written", ["'1'", '"1e3"', "!!str 1", "1e", "one", "2020-01-01", "0x1g"])
def test_text_is_no_number(written):
    assert "number is expected" in refusal(scene_text(f"mass: {written}"))


@pytest.mark.parametrize("written", ["true", "false", "yes", "off", "[1]", "{a: 1}"])
def test_other_kinds_are_no_number(written):
    assert re.match(
        r"scene.yaml:4:\d+: agents\[0\]\.mass: .* number is expected",
        refusal(scene_text(f"mass: {written}")),
    )


@pytest.mark.parametrize("written", [".nan", ".inf", "-.inf", "1e999", "-1e999", ".NaN"])
@pytest.mark.parametrize("key", ["mass", "radius", "start_time", "max_time", "preferred_time"])
def test_numbers_are_finite(written, key):
    assert f"agents[0].{key}: " in refusal(scene_text(f"{key}: {written}"))


@pytest.mark.parametrize("digits", [20, 400, 5000, 100_000])
def test_huge_integers(digits):
    messages = refusals(scene_text(f"mass: {'9' * digits}"))
    assert places(messages)[0][0] == 4
    assert max(map(len, messages)) < 300


def test_huge_integers_in_other_bases():
    assert len(refusals(scene_text(f"mass: 0x{'f' * 3900}"))[0]) < 300
    assert len(refusals(scene_text(f"mass: {':'.join(['59'] * 900)}"))[0]) < 300


@pytest.mark.parametrize(
    "tag", ["!!python/object:os.system x", "!!python/name:os.system ''", "!x y"]
)
def test_tags_are_refused(tag):
    assert places(refusals(scene_text(f"mass: {tag}")))[0][0] == 4


@pytest.mark.parametrize("tagged", ["!!int ''", "!!float abc", "!!bool maybe", "!!binary aGk="])
def test_wrongly_tagged_values(tagged):
    assert places(refusals(scene_text(f"mass: {tagged}")))[0][0] == 4


@pytest.mark.parametrize("key", ["3", "true", "null", "[a]", "{a: b}"])
def test_keys_are_text(key):
    assert places(refusals(scene_text(f"? {key} : 1")))[0][0] == 4


@pytest.mark.parametrize("text", ["3", "[]", "[1, 2]", "text", "true"])
def test_no_mapping(text):
    assert "mapping" in refusal(text)


@pytest.mark.parametrize(
    "text",
    ["a: b: c", "a: [1", "\tx: 1", "a: *b", "a: 'b", "%YAML 9.9\n---\na: 1", "\x00", "\ud800"],
)
def test_broken_yaml_is_located(text):
    assert re.match(r"scene.yaml:\d+:\d+: .*", refusal(text))


@pytest.mark.parametrize("text", ["&a [*a]", "&a {b: *a}", "a: &a {b: [*a]}", "&a {? *a : 1}"])
def test_recursive_aliases(text):
    assert places(refusals(text))


def test_aliases_repeat_values():
    text = scene_text("weights: &w {kinetic: 2}").replace(
        "goal: [5, 2]", "goal: [5, 2], weights: *w"
    )
    assert [agent.weights.kinetic for agent in parse_scene(text).agents] == [2, 2]


@pytest.mark.parametrize("opening", ["[", "{", "- ", "{a: ", "[[", "? "])
@pytest.mark.parametrize("count", [DEEPEST + 2, 200_000])
def test_deep_nesting_is_refused(opening, count):
    # In a process of its own: a parser that recurses would take the tests with it.
    code = (
        "from stplan.errors import SceneError\nfrom stplan.scene import parse_scene\n"
        f"try: parse_scene({opening!r} * {count})\nexcept SceneError: print('refused')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout) == (0, "refused\n"), done.stderr[-300:]


def test_places_count_characters():
    assert read_tree("{'ü€😀': 1, b: 2}", "scene").locations["b"] == (1, 12)
