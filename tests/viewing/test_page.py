"""The page as a file: complete, up to date, and what is in it."""

from __future__ import annotations

import hashlib
import json
import re
from importlib import resources
from pathlib import Path

import pytest

import stplan.viewing
from stplan.viewing.page import page_bytes, page_content
from stplan.viewing.run_view import open_run
from tests.viewing.runs import CURVES, EVENTS, HALL, hall_run, write_run

PAGE = Path(stplan.viewing.__file__).parent / "page"


@pytest.fixture
def view(tmp_path):
    return open_run(hall_run(tmp_path))


def test_the_built_page_is_that_of_its_sources():
    sources = [*sorted((PAGE / "source").iterdir()), PAGE / "build.mjs", PAGE / "package-lock.json"]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    built = resources.files("stplan.viewing").joinpath("page/built/page.html").read_text("utf-8")
    assert built.startswith(f"<!-- sources {digest} -->"), "run `make page`"
    assert "three-license.txt" in {path.name for path in (PAGE / "built").iterdir()}


def test_the_page_loads_nothing(view):
    text = page_bytes(view).decode()
    assert "default-src 'none'" in text
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=.(?!data:)", text)


def test_no_text_of_a_scene_ends_the_element_it_stands_in(view):
    text = page_bytes(view).decode()
    written = re.search(r'<script id="run" type="application/json">(.*?)</script>', text, re.DOTALL)
    assert written is not None
    content = json.loads(written.group(1))
    assert content["description"] == "two cross, one waits </script>"
    assert content == json.loads(json.dumps(page_content(view)))


def test_a_second_run_is_matched_by_id(view, tmp_path):
    (tmp_path / "later").mkdir()
    later = write_run(tmp_path / "later", SWAPPED, [CURVES[1] + [0, 0, 2.0], CURVES[0], CURVES[2]])
    content = page_content(view, open_run(later), ["before", "after"])
    other = content["other"]
    assert (content["title"], other["title"]) == ("before", "after")
    assert (content["arrived"], content["end"], other["end"]) == (9.0, 9.0, 9.0)
    assert [agent["row"] for agent in other["agents"]] == [1, 0, None]
    assert other["agents"][0]["colour"] == content["agents"][1]["colour"]
    assert other["missing"] == ["cat"]
    ben, ann = other["differences"]
    assert (ben["a"], ben["later"], ann["distance"]) == (1, 2.0, 0.0)
    assert ben["distance"] > 0.5


SWAPPED = """\
stplan: 1
name: hall
horizon: 12.0
defaults: {radius: 0.3}
agents:
  - {id: ben, start: [0.0, -2.5], goal: [0.0, 1.5], radius: 0.4, start_time: 2.0}
  - {id: ann, start: [-4.0, 0.0], goal: [4.0, 0.0]}
  - {id: dog, start: [4.0, -2.0], goal: [-4.0, -2.5], start_time: 1.0, after_arrival: vanish}
"""


def test_what_the_page_knows(view):
    content = page_content(view)
    ann, ben, cat = content["agents"]
    assert ann["knots"] == [[-4.0, 0.0, 0.0], [4.0, 0.0, 8.0]]
    assert (ann["preferred"], ben["preferred"]) == (7.0, None)
    assert (ann["length"], ann["mean"], ann["top"]) == pytest.approx((8.0, 1.0, 1.0))
    assert ben["waits"] == [{"begin": 1.5, "end": 5.0, "b": 0}]
    assert cat["leaves"] == 9.0
    assert len(content["moments"]) == 3 + 3
    assert sum(moment["b"] is None for moment in content["moments"]) == 3
    (part,) = content["map"]
    assert sorted(map(tuple, part[0]))[0] == (-5.0, -3.0)
    assert content["seed"][0][0] == [-4.0, 0.05, 0.0]


def test_events_are_in_it(view, tmp_path):
    assert page_content(view)["events"] == []
    (tmp_path / "changing").mkdir()
    changing = open_run(write_run(tmp_path / "changing", HALL + EVENTS, CURVES))
    assert page_content(changing)["events"] == [
        {"time": 1.0, "what": "the <b> door closes", "still": []},
        {"time": 6.0, "what": "cat goes 0.5 m/s at most", "still": []},
    ]
    (tmp_path / "stopped").mkdir()
    delay = "events: [{at: 1.5, agent: ben, delay: 3.5}]\n"
    stopped = open_run(write_run(tmp_path / "stopped", HALL + delay, CURVES))
    assert page_content(stopped)["events"][0]["still"] == [{"a": 1, "until": 5.0}]
