"""Runs that go on with what became known later."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stplan.errors import SceneError, UsageError
from stplan.files.npz_file import read_npz
from stplan.planned import write_plan
from stplan.problem.continuation import curves_of
from stplan.replanned_run import Happening, events_of, open_continuation, set_event
from stplan.replanning.execution import check, plan
from stplan.scene import load_scene

SCENE = """
stplan: 1
name: room
horizon: 20
map: {rectangle: [-1, -1, 11, 9]}
agents:
  - {id: ann, start: [0, 4], goal: [10, 4]}
  - {id: bob, start: [10, 4.3], goal: [0, 4.3]}
"""


def given(event: dict[str, Any]) -> Happening:
    return Happening(event, "somewhere")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    path = tmp_path / "room.yaml"
    path.write_text(SCENE, encoding="utf-8")
    write_plan(plan(load_scene(path)), tmp_path / "run")
    return tmp_path / "run"


def test_a_run_is_replanned_again_and_again(run, tmp_path) -> None:
    first = open_continuation(run, [set_event(6.0, ["agents.ann.goal=[9, 8]"])])
    write_plan(first.replanned(), tmp_path / "second")
    second = open_continuation(tmp_path / "second", [given({"at": 9, "agent": "bob", "delay": 2})])
    assert [change.at for change in second.scene.changes] == [6, 9]
    assert [change.at for change in second.changes] == [9]
    found = second.replanned()
    assert found.certificate.holds
    write_plan(found, tmp_path / "third")
    lines = read_npz(tmp_path / "third" / "trajectories.npz").world_lines
    assert check(second.scene, lines).holds
    old = curves_of(read_npz(tmp_path / "second" / "trajectories.npz").world_lines)
    for name, curve in curves_of(lines).items():
        past = old[name][old[name][:, 2] <= 9]
        np.testing.assert_array_equal(curve[: len(past)], past)


def test_the_rest_of_the_old_plan_is_judged(run) -> None:
    clear = open_continuation(run, [given({"at": 6, "agent": "ann", "goal": [9, 8]})]).rest()
    assert clear is not None
    assert clear.holds
    wall = {"at": 6, "obstacle": {"rectangle": [7, -1, 7.5, 9]}}
    blocked = open_continuation(run, [given(wall)]).rest()
    assert blocked is not None
    assert not blocked.holds


def test_what_does_not_fit_is_refused(run, tmp_path) -> None:
    with pytest.raises(SceneError, match="there is no agent 'zoe'"):
        open_continuation(run, [given({"at": 6, "agent": "zoe", "delay": 1})])
    with pytest.raises(SceneError, match="KEY=VALUE is expected"):
        set_event(6.0, ["agents.ann.goal"])
    write_plan(
        open_continuation(run, [given({"at": 9, "agent": "bob", "delay": 2})]).replanned(),
        tmp_path / "b",
    )
    with pytest.raises(UsageError, match="knows what happens until 9 s"):
        open_continuation(tmp_path / "b", [given({"at": 8, "agent": "ann", "delay": 2})])
    (run / "seed.csv").write_text("", encoding="utf-8")
    with pytest.raises(UsageError, match="is not the whole of one run"):
        open_continuation(run, [given({"at": 9, "agent": "bob", "delay": 2})])


def test_a_run_of_another_state_of_its_scene_is_refused(run, tmp_path) -> None:
    (tmp_path / "room.yaml").write_text(SCENE.replace("[10, 4]", "[10, 5]"), encoding="utf-8")
    with pytest.raises(UsageError, match="is not as it was"):
        open_continuation(run, [given({"at": 9, "agent": "bob", "delay": 2})])


@pytest.mark.parametrize("text", ["- {at: 1, remove: a}", "events: [{at: 1, remove: a}]"])
def test_events_stand_in_a_file_of_their_own(tmp_path, text) -> None:
    path = tmp_path / "events.yaml"
    path.write_text(text, encoding="utf-8")
    assert [one.event for one in events_of(path)] == [{"at": 1, "remove": "a"}]
    path.write_text("agents: 1", encoding="utf-8")
    with pytest.raises(SceneError, match="a list of events is expected"):
        events_of(path)


def test_faults_of_events_are_named_where_they_were_given(run, tmp_path) -> None:
    path = tmp_path / "events.yaml"
    for text, expected in [
        (
            "- {at: 2, remove: ann}\n- {at: 30, remove: bob}\n",
            ":2:3: events[1]: at: is 30 s; a time",
        ),
        ("events:\n  - {at: 2, remove: zoe}\n", ":2:5: events[0]: there is no agent 'zoe'"),
        ("- {at: 2}\n", ":1:3: events[0]: has none of agent, add, remove, obstacle and set"),
    ]:
        path.write_text(text, encoding="utf-8")
        with pytest.raises(SceneError) as refused:
            open_continuation(run, events_of(path))
        (message,) = refused.value.messages
        assert message.startswith(str(path) + expected), message
    with pytest.raises(SceneError, match=r"^--set agents.ann.radius=-1: agents\[0\].radius: is -1"):
        open_continuation(run, [set_event(2.0, ["agents.ann.radius=-1"])])


def test_files_of_events_are_read_as_strictly_as_scenes(tmp_path) -> None:
    path = tmp_path / "events.yaml"
    for text, fault in [
        ("", ":1:1: the file is empty; a list of events is expected"),
        ("- {at: 2, at: 3, remove: ann}\n", ":1:11: .*"),
    ]:
        path.write_text(text, encoding="utf-8")
        with pytest.raises(SceneError, match=str(path) + fault):
            events_of(path)
    with pytest.raises(SceneError, match=r"^--set agents.ann=\{goal: 1, goal: 2\}: "):
        set_event(2.0, ["agents.ann={goal: 1, goal: 2}"])
