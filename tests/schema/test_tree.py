"""YAML text becomes a plain tree with places, or is refused before it can do harm."""

from __future__ import annotations

import math
import time

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.errors import SceneError
from stplan.schema.yaml_nodes import DEEPEST, LARGEST_FILE, MOST_VALUES
from stplan.schema.yaml_tree import LONGEST_KEY, read_tree


def refusal(text: str) -> str:
    with pytest.raises(SceneError) as refused:
        read_tree(text, "s.yaml")
    return str(refused.value)


def test_places_are_those_of_keys_and_of_entries():
    tree = read_tree("a: 1\nb:\n  - {c: 2, dé: [3, 4]}\n  - 5\n", "s.yaml")
    assert tree.value == {"a": 1, "b": [{"c": 2, "dé": [3, 4]}, 5]}
    assert tree.locations == {
        "": (1, 1),
        "a": (1, 1),
        "b": (2, 1),
        "b[0]": (3, 5),
        "b[0].c": (3, 6),
        "b[0].dé": (3, 12),
        "b[0].dé[0]": (3, 17),
        "b[0].dé[1]": (3, 20),
        "b[1]": (4, 5),
    }


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("+1", 1),
        ("-12_000", -12000),
        ("0x1F", 31),
        ("0b11", 3),
        ("1.", 1.0),
        (".5", 0.5),
        ("1e-3", 1e-3),
        ("1E3", 1e3),
        ("-5.5e+3", -5500.0),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("yes", True),
        ("Off", False),
        ("true", True),
        ("~", None),
        ("null", None),
        ("'1'", "1"),
        ('"yes"', "yes"),
        ("010", "010"),
        ("007", "007"),
        ("1:30", "1:30"),
        ("2026-01-01", "2026-01-01"),
        ("1e", "1e"),
        ("-", "-"),
        (".", "."),
        ("e5", "e5"),
        ("inf", "inf"),
        ("!!str 1", "1"),
        ("!!float 1", 1.0),
        ("!!int '7'", 7),
        ("!!bool yes", True),
        ("! 1", "1"),
        ("|\n  two\n  lines\n", "two\nlines\n"),
        ("ünï 😀", "ünï 😀"),
    ],
)
def test_values(text, value):
    result = read_tree(f"[{text}]" if "\n" not in text else f"- {text}", "s.yaml").value[0]
    assert (result, type(result)) == (value, type(value))


def test_nan_is_a_number():
    assert all(math.isnan(value) for value in read_tree("[.nan, .NaN]", "s.yaml").value)


@settings(derandomize=True, deadline=None)
@given(
    st.recursive(
        st.none()
        | st.booleans()
        | st.integers(-(10**9), 10**9)
        | st.floats(allow_nan=False)
        | st.text(max_size=20),
        lambda inner: (
            st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4)
        ),
        max_leaves=20,
    )
)
def test_what_is_written_is_read(value):
    text = yaml.safe_dump([value], allow_unicode=True)
    tree = read_tree(text, "s.yaml")
    if "<<" not in text:
        assert tree.value == yaml.safe_load(text) == [value]


def test_aliases_and_merges_give_copies():
    tree = read_tree(
        "a: &a {x: 1, y: 2}\nb: *a\nc: {<<: *a, y: 3}\nd: {<<: [*a, {z: 4}]}", "s.yaml"
    )
    assert tree.value["b"] == {"x": 1, "y": 2}
    assert tree.value["b"] is not tree.value["a"]
    assert tree.value["c"] == {"x": 1, "y": 3}
    assert tree.value["d"] == {"x": 1, "y": 2, "z": 4}
    assert tree.locations["c.y"] == (3, 13)
    assert tree.locations["c.x"] == (1, 8)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "s.yaml:1:1: the file is empty; a scene is expected"),
        ("# only a comment\n", "s.yaml:1:1: the file is empty; a scene is expected"),
        ("---\n...\n", "s.yaml:1:1: the file is empty; a scene is expected"),
        (
            "a: 1\n---\nb: 2\n",
            "s.yaml:2:1: a second document starts; one scene a file is expected",
        ),
        ("a: *b", "s.yaml:1:4: not valid YAML: the alias *b has no anchor before it"),
        ("x:\n  y: &a [1, *a]", "s.yaml:2:13: the alias *a stands inside what it names"),
        ("a: @x", "s.yaml:1:4: not valid YAML: found character that cannot start any token"),
        ("a: \x01", "s.yaml:1:4: not valid YAML: the character U+0001 is not allowed in YAML"),
        ("é: \ud800", "s.yaml:1:4: not valid YAML: the character U+D800 is not allowed in YAML"),
        ("[" * 5_000_000, f"nested more than {DEEPEST} levels deep"),
        ("{a: " * 1_000_000, "nested more than"),
        ("- " * 1_000_000, f"s.yaml:1:{2 * DEEPEST + 1}: nested more than {DEEPEST} levels deep"),
        ("a" * (LARGEST_FILE + 1), "s.yaml:1:1: the file is larger than 16 MiB"),
        ("a: 'open", "s.yaml:1:9: not valid YAML: "),
        ("a: 1\n b: 2", "s.yaml:2:3: not valid YAML: mapping values are not allowed"),
    ],
)
def test_refused(text, message):
    began = time.process_time()
    assert message in refusal(text)
    assert time.process_time() - began < 5


def test_depth_counts_through_aliases():
    steps = "\n".join(f"a{k}: &a{k} [[[*a{k - 1}]]]" for k in range(1, 30))
    assert f"nested more than {DEEPEST} levels deep" in refusal(f"a0: &a0 [1]\n{steps}")


def test_alias_bomb_is_refused_at_once():
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    for k in range(1, 110_000):
        lines.append(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]")
    text = "\n".join(lines)
    assert 10_000_000 < len(text) < LARGEST_FILE
    began = time.process_time()
    assert refusal(text) == (
        f"s.yaml:6:45: the file holds more than {MOST_VALUES} values, "
        "aliases counted as often as used"
    )
    assert time.process_time() - began < 5


def test_wide_file_is_refused_in_time():
    began = time.process_time()
    assert f"more than {MOST_VALUES} values" in refusal("[" + "1, " * 3_000_000 + "]")
    assert time.process_time() - began < 20


@pytest.mark.parametrize(
    ("text", "path", "place", "message"),
    [
        ("a: 1\nb: 2\na: 3", "a", (3, 1), "this key stands here twice, first in line 1, column 1"),
        ("x: {1: 2}", "x", (1, 5), "has the key 1, which is no text; in quotes it is: '1'"),
        ("yes: 2", "", (1, 1), "has the key yes, which is no text; in quotes it is: 'yes'"),
        ("[a]: 2", "", (1, 1), "has the key a list or mapping, which is no text"),
        ("x: !!python/object:os.system rm", "x", (1, 1), "the tag 'tag:yaml.org,2002:python/obj"),
        ("x: !mine [1]", "x", (1, 1), "the tag '!mine' is not expected in a scene"),
        ("x: !!binary aGk=", "x", (1, 1), "the tag 'tag:yaml.org,2002:binary' is not expected"),
        ("x: !!int one", "x", (1, 1), "'one' is no !!int"),
        (f"x: {'9' * 5000}", "x", (1, 1), "is a number of 5000 characters, which is too long"),
        (
            f"{'k' * (LONGEST_KEY + 1)}: 1",
            "",
            (1, 1),
            "has a key of 101 characters; at most 100 are expected",
        ),
        ("x: {<<: 3}", "x", (1, 9), "'<<' merges mappings; another value is here"),
    ],
)
def test_stepped_over(text, path, place, message):
    ((found_path, found_place, found),) = read_tree(text, "s.yaml").faults
    assert (found_path, found_place) == (path, place)
    assert message in found


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.text(alphabet="ab:-[]{},&*!|>'\"#%@?\n\t 10.~<é\x00\ud800", max_size=60))
def test_any_text_is_read_or_refused(text):
    messages = ["s.yaml: read"]
    try:
        read_tree(text, "s.yaml")
    except SceneError as error:
        messages = error.messages
    assert all(message.startswith("s.yaml:") for message in messages)
