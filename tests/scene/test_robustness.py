"""Whatever a file holds, the answer is a scene or a `SceneError` with places."""

from __future__ import annotations

import re

import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.errors import SceneError
from stplan.scene import Scene, parse_scene
from tests.scene.samples import FULL, dump, full_tree

TREES = [yaml.safe_load(FULL.replace("1e-6", "1.0e-6")), full_tree()]
PLACED = re.compile(r"scene:\d+:\d+: ")

scalars = (
    st.none()
    | st.booleans()
    | st.integers(-3, 3)
    | st.integers(-(10**400), 10**400)
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(
        ["auto", "inf", "all", "sam", "ann", "stay", "x.obj", "\x85", "=", "\U0001f600"]
    )
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(
                ["id", "radius", "mesh", "rectangle", "a", "between", "circle", "path"]
            ),
            inner,
            max_size=3,
        )
    ),
    max_leaves=6,
)


def places(value, here=()):
    yield here
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places(inner, (*here, key))
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from places(inner, (*here, index))


PLACES = [(number, place) for number, tree in enumerate(TREES) for place in places(tree) if place]


def changed(value, place, what, new):
    """A copy of `value` with the entry at `place` replaced, removed, renamed or repeated."""
    head, rest = place[0], place[1:]
    copy = dict(value) if isinstance(value, dict) else list(value)
    if rest:
        copy[head] = changed(copy[head], rest, what, new)
    elif what == "replace":
        copy[head] = new
    elif what == "remove":
        del copy[head]
    elif isinstance(copy, list):
        copy.insert(head, copy[head])
    else:
        copy[f"{head}s"] = copy.pop(head)
    return copy


@settings(derandomize=True, deadline=None, max_examples=700)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(PLACES), st.sampled_from(["replace", "remove", "rename"]), values
        ),
        min_size=1,
        max_size=3,
    )
)
def test_mutations_give_a_scene_or_located_faults(changes):
    chosen = changes[0][0][0]
    tree = TREES[chosen]
    for (number, place), what, new in changes:
        if number != chosen:
            continue
        try:
            tree = changed(tree, place, what, new)
        except (KeyError, IndexError, TypeError, AttributeError):
            continue
    answer(dump(tree))


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.integers(0, len(FULL) - 1), st.integers(0, 8), st.text(max_size=4))
def test_damaged_text_gives_a_scene_or_located_faults(at, length, inserted):
    answer(FULL[:at] + inserted + FULL[at + length :])


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.text(alphabet="agents.[]0129solvermu=-: {}", max_size=30))
def test_any_override_gives_a_scene_or_a_fault(override):
    messages = ["--set"]
    try:
        parse_scene(FULL, overrides=[override])
    except SceneError as error:
        messages = error.messages
    assert messages


def answer(text: str) -> None:
    try:
        scene = parse_scene(text)
    except SceneError as error:
        messages = error.messages
    else:
        assert isinstance(scene, Scene)
        return
    assert messages
    assert len(set(messages)) == len(messages)
    for message in messages:
        assert PLACED.match(message), message
        assert "Input should" not in message
        assert "pydantic" not in message
