"""JSON: repeatable, exact, and never NaN."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stplan.errors import UsageError
from stplan.files.json_file import json_bytes, read_json

values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(exclude_categories=["Cs"])),
    lambda inner: st.lists(inner) | st.dictionaries(st.text("abc"), inner),
    max_leaves=12,
)


@given(values)
def test_any_content_survives(content):
    assert json.loads(json_bytes(content)) == content


def test_layout_keeps_the_order_and_rows_on_a_line():
    content = {"b": 1, "a": {"rows": [["x", 0.1], ["y", 2.0]], "none": [], "empty": {}}}
    assert json_bytes(content).decode() == (
        '{\n  "b": 1,\n  "a": {\n    "rows": [\n      ["x", 0.1],\n      ["y", 2.0]\n    ],\n'
        '    "none": [],\n    "empty": {}\n  }\n}\n'
    )


def test_what_json_cannot_say_is_null():
    content = {"a": [math.inf, -math.inf, math.nan], "b": np.array([1.0, np.nan])}
    assert json.loads(json_bytes(content)) == {"a": [None] * 3, "b": [1.0, None]}


def test_other_types():
    content = (np.float64(0.1), np.int64(3), np.bool_(True), Path("a") / "b", "é")
    text = json_bytes(content).decode()
    assert json.loads(text) == [0.1, 3, True, "a/b", "é"]
    assert "é" in text
    with pytest.raises(TypeError, match="object has no form in JSON"):
        json_bytes([object()])


@pytest.mark.parametrize(
    ("content", "message"),
    [(b'{"a": }', r"r\.json:1:7: "), (b"[]", "expected a JSON object"), (b"\xff", "r.json: ")],
)
def test_reading_locates_faults(tmp_path, content, message):
    (tmp_path / "r.json").write_bytes(content)
    with pytest.raises(UsageError, match=message):
        read_json(tmp_path / "r.json")
    with pytest.raises(UsageError, match="cannot read"):
        read_json(tmp_path / "none.json")
