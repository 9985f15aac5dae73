"""Untrusted text: what is read, what is refused, and where the refusal points."""

from __future__ import annotations

import re
import subprocess
import sys
import time

import pytest

from stplan.errors import SceneError
from stplan.scene import load_scene, parse_scene
from stplan.scene.reader import DEEPEST, LARGEST_FILE, read_tree
from tests.scene.samples import places, refusal, refusals, scene_text


@pytest.mark.parametrize(
    ("written", "value"),
    [("1e-3", 1e-3), ("1E3", 1000), ("2.5e+1", 25), (".5", 0.5), ("1.", 1), ("+2", 2), ("3", 3)],
)
def test_numbers(written, value):
    assert parse_scene(scene_text(f"mass: {written}")).agents[0].mass == value


@pytest.mark.parametrize("written", ["'1'", '"1e3"', "!!str 1", "1e", "one", "2020-01-01", "0x1g"])
def test_text_is_no_number(written):
    assert "number is expected" in refusal(scene_text(f"mass: {written}"))


@pytest.mark.parametrize("written", ["true", "false", "yes", "off", "[1]", "{a: 1}"])
def test_other_kinds_are_no_number(written):
    assert re.match(
        r"scene:4:\d+: agents\[0\]\.mass: .* number is expected",
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


def test_duplicate_keys():
    message = refusal(scene_text("radius: 0.1, radius: 0.2"))
    assert message.startswith("scene:4:")
    assert "agents[0].radius" in message
    assert "twice" in message


@pytest.mark.parametrize("key", ["3", "true", "null", "[a]", "{a: b}"])
def test_keys_are_text(key):
    assert places(refusals(scene_text(f"? {key} : 1")))[0][0] == 4


@pytest.mark.parametrize("text", ["", "\n\n", "# only a comment\n", "---\n...\n"])
def test_empty(text):
    assert "empty" in refusal(text)


@pytest.mark.parametrize("text", ["3", "[]", "[1, 2]", "text", "true"])
def test_no_mapping(text):
    assert "mapping" in refusal(text)


def test_several_documents():
    assert "document" in refusal(scene_text(top="---\nstplan: 1"))


@pytest.mark.parametrize(
    "text",
    ["a: b: c", "a: [1", "\tx: 1", "a: *b", "a: 'b", "%YAML 9.9\n---\na: 1", "\x00", "\ud800"],
)
def test_broken_yaml_is_located(text):
    assert re.match(r"scene:\d+:\d+: .*", refusal(text))


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


def _laughs() -> str:
    levels = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, 30))
    rows = "".join(f"b{k}: [{','.join(['*a3'] * 1000)}]\n" for k in range(2500))
    return f"a0: &a0 [1, 2]\n{levels}{rows}"


def test_nested_aliases_of_10_mb():
    text = _laughs()
    assert len(text) > 10_000_000
    begin = time.monotonic()
    assert places(refusals(text))
    assert time.monotonic() - begin < 5


def test_too_large(tmp_path):
    assert "larger than" in refusal("#" * (LARGEST_FILE + 1))
    path = tmp_path / "large.yaml"
    path.write_bytes(b"#" * (LARGEST_FILE + 1))
    with pytest.raises(SceneError, match="larger than"):
        load_scene(path)


def test_places_of_everything():
    tree = read_tree("a:\n  b: [1, {c: 2}]\n'd': x\n", "scene")
    assert tree.value == {"a": {"b": [1, {"c": 2}]}, "d": "x"}
    assert tree.locations["a.b"] == (2, 3)
    assert tree.locations["a.b[0]"] == (2, 7)
    assert tree.locations["a.b[1].c"] == (2, 11)
    assert tree.locations["d"] == (3, 1)


def test_places_count_characters():
    assert read_tree("{'ü€😀': 1, b: 2}", "scene").locations["b"] == (1, 12)


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"name: \xe4\xf6", b"\x80" * 100])
def test_no_utf8(tmp_path, content):
    path = tmp_path / "latin.yaml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match="UTF-8") as caught:
        load_scene(path)
    assert str(caught.value).startswith(str(path))


def test_byte_order_mark(tmp_path):
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + scene_text().replace("\n", "\r\n").encode())
    assert load_scene(path).name == "windows"


def test_files_that_are_none(tmp_path):
    for path in (tmp_path / "absent.yaml", tmp_path, tmp_path / "a\0b.yaml"):
        with pytest.raises(SceneError):
            load_scene(path)


def test_reading_needs_no_heavy_library():
    code = (
        "import sys, stplan.scene\n"
        "print([n for n in ('shapely', 'scipy', 'numba', 'trimesh') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
