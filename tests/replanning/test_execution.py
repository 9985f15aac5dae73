"""Plans that are mended when the world changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.errors import SeedingError, UsageError
from stplan.files.csv_file import csv_bytes
from stplan.files.json_file import json_bytes
from stplan.planned import Plan
from stplan.planner import prepare
from stplan.problem.continuation import curves_of
from stplan.problem.world_lines import WorldLines
from stplan.replanning.execution import check, plan, replan
from stplan.scene import parse_scene

ROOM = """
stplan: 1
name: room
horizon: 20
solver: {effort: quick}
map: {rectangle: [-1, -1, 11, 9]}
defaults: {radius: 0.4}
agents:
  - {id: ann, start: [0, 4], goal: [10, 4]%s}
  - {id: bob, start: [10, 4.3], goal: [0, 4.3]}
  - {id: eve, start: [5, 0], goal: [5, 8]}
"""


def calm(ann: str = "") -> str:
    return ROOM % ann


def planned(events: str, ann: str = "") -> Plan:
    """The executed whole, which holds its certificate, and is found clear again from its text."""
    scene = parse_scene(calm(ann) + f"events:\n{events}\n")
    found = plan(scene)
    assert found.certificate.holds, found.certificate.violations
    assert found.trajectories is not None
    assert check(scene, found.trajectories).holds
    return found


def curve(found: Plan, name: str) -> np.ndarray:
    assert found.trajectories is not None
    return curves_of(found.trajectories)[name]


@pytest.fixture(scope="module")
def before() -> Plan:
    return plan(parse_scene(calm()))


EVENTS = {
    "a delay": "  - {at: 7, agent: eve, delay: 4}",
    "a goal": "  - {at: 7, agent: ann, goal: [8, 0]}",
    "a limit": "  - {at: 7, agent: ann, max_speed: 0.6}",
    "an obstacle": "  - {at: 6, obstacle: {rectangle: [0.5, 3, 1.5, 5.5]}, until: 18}",
    "a newcomer": "  - {at: 6, add: {id: sam, start: [8, 8], goal: [2, 0]}}",
    "a farewell": "  - {at: 6, remove: bob}",
    "anything": "  - {at: 6, set: {agents.ann.goal: [9, 8], agents.bob.radius: 0.5}}",
}


@pytest.mark.parametrize("name", ["a goal", "a newcomer"])
def test_a_plan_gone_on_with_is_that_of_the_scene_with_its_events(before, name) -> None:
    scene = parse_scene(calm() + f"events:\n{EVENTS[name]}\n")
    mended = replan(before, scene)
    assert csv_bytes(mended.trajectories) == csv_bytes(planned(EVENTS[name]).trajectories)
    # And once more, when something else happens.
    more = "  - {at: 11, agent: eve, goal: [3, 8]}"
    again = replan(mended, parse_scene(calm() + f"events:\n{EVENTS[name]}\n{more}\n"))
    assert again.certificate.holds
    assert curve(again, "eve")[-1, :2].tolist() == [3.0, 8.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (calm(), "nothing happens that the plan does not know"),
        (calm(", start_time: 1") + f"events:\n{EVENTS['a goal']}\n", "no plan of the scene"),
        (
            "stplan: 1\nhorizon: 9\nagents:\n  - {id: a, start: [0, 0], goal: {pursue: b}, max_speed: 1}\n"
            "  - {id: b, start: [5, 0], goal: {evade: a}, max_speed: 1}\nmap: {rectangle: [-9, -9, 9, 9]}\n",
            "goals that move",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_gone_on_with_is_refused(before, text, said) -> None:
    with pytest.raises(UsageError, match=said):
        replan(before, parse_scene(text))


@pytest.mark.parametrize("name", EVENTS)
def test_the_past_is_kept_to_the_byte_and_nobody_jumps(before, name) -> None:
    found = planned(EVENTS[name])
    at = float(EVENTS[name].partition("at: ")[2].partition(",")[0])
    for agent, old in curves_of(before.trajectories or before.seed).items():
        new = curve(found, agent)
        past = old[old[:, 2] <= at]
        np.testing.assert_array_equal(new[: len(past)], past)
        if name != "a delay" or agent != "eve":
            # The segment that was being passed goes on in its direction.
            segment = old[len(past)] - old[len(past) - 1]
            later = new[len(past)] - new[len(past) - 1]
            np.testing.assert_allclose(
                later[:2] / later[2], segment[:2] / segment[2], rtol=1e-7, atol=1e-9
            )


def test_who_is_delayed_stands_still(before) -> None:
    found = curve(planned(EVENTS["a delay"]), "eve")
    times = np.linspace(7, 11, 9)
    places = [np.interp(times, found[:, 2], found[:, axis]) for axis in range(2)]
    assert np.ptp(places[0]) < 1e-9
    assert np.ptp(places[1]) < 1e-9


def test_goals_limits_and_farewells_are_kept() -> None:
    assert tuple(curve(planned(EVENTS["a goal"]), "ann")[-1, :2]) == (8, 0)
    slow = curve(planned(EVENTS["a limit"]), "ann")
    later = slow[np.flatnonzero(slow[:, 2] >= 7)[0] :]
    step = np.diff(later, axis=0)
    assert (np.hypot(step[:, 0], step[:, 1]) / step[:, 2]).max() <= 0.6 * (1 + 1e-9)
    assert curve(planned(EVENTS["a farewell"]), "bob")[-1, 2] == 6.0
    assert curve(planned(EVENTS["a newcomer"]), "sam")[0].tolist() == [8.0, 8.0, 6.0]


def test_accelerations_are_limited_across_events() -> None:
    found = planned("  - {at: 7, agent: ann, goal: [8, 0]}", ann=", max_acceleration: 0.6")
    (peak,) = found.certificate.limits
    assert peak.holds
    assert peak.reached > 0.05


def test_waypoints_ahead_are_passed_after_an_event() -> None:
    ann = ", waypoints: [[2, 5], {at: [7, 2], dwell: 1.5}]"
    found = curve(planned("  - {at: 8, agent: eve, delay: 3}", ann=ann), "ann")
    near = found[np.hypot(*(found[:, :2] - [7, 2]).T) < 1e-6]
    assert np.ptp(near[:, 2]) >= 1.5 - 1e-9


def test_what_is_not_concerned_goes_its_way() -> None:
    """Ann's other goal is far from where eve goes: her curve stays what it was, but for rounding."""
    far = plan(parse_scene(calm() + "events:\n  - {at: 18, agent: ann, goal: [10, 5]}\n"))
    old = plan(parse_scene(calm()))
    ours, theirs = curve(far, "eve"), curve(old, "eve")
    assert ours.shape == theirs.shape
    assert np.abs(ours - theirs).max() < 0.05


def test_runs_repeat_to_the_byte() -> None:
    events = EVENTS["a delay"] + "\n" + EVENTS["an obstacle"]
    first, second = planned(events), planned(events)
    assert first.trajectories is not None
    assert second.trajectories is not None
    assert csv_bytes(first.trajectories) == csv_bytes(second.trajectories)
    assert csv_bytes(first.seed) == csv_bytes(second.seed)
    assert json_bytes(first.report.as_dict()) == json_bytes(second.report.as_dict())


def test_where_there_is_no_way_to_go_on_it_is_said() -> None:
    wall = "  - {at: 6, obstacle: {rectangle: [5.9, -1, 6.1, 9]}}"
    with pytest.raises(SeedingError, match="ann: its start and goal lie in separate parts"):
        planned(wall)


def test_only_whole_executions_are_planned_with_events() -> None:
    with pytest.raises(UsageError, match="has events"):
        prepare(parse_scene(calm() + "events:\n  - {at: 6, remove: bob}\n"))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda c: c["bob"][-1].__setitem__(2, 6.5), "bob: is there after 6 s, when it is removed"),
        (lambda c: c["ann"][-1].__setitem__(0, 9.0), "ann: ends at"),
        (lambda c: c["ann"].__setitem__((slice(1, -1), 1), 12), "ann: leaves"),
    ],
)
def test_broken_promises_are_found(damage, sentence) -> None:
    found = planned(EVENTS["a farewell"])
    assert found.trajectories is not None
    scene = parse_scene(calm() + f"events:\n{EVENTS['a farewell']}\n")
    curves = {name: one.copy() for name, one in curves_of(found.trajectories).items()}
    damage(curves)
    lines = WorldLines.from_curves(list(curves), list(curves.values()))
    certificate = check(scene, lines)
    assert any(one.startswith(sentence.partition(":")[0]) for one in certificate.violations)
    assert any(sentence in one or "free space" in one for one in certificate.violations)


def test_obstacles_count_only_while_they_are_there() -> None:
    scene = parse_scene(calm() + f"events:\n{EVENTS['an obstacle']}\n")
    old = plan(parse_scene(calm()))
    certificate = check(scene, old.trajectories or old.seed)
    assert not certificate.holds
    early = replace(
        scene, changes=(replace(scene.changes[0], at=13.0), replace(scene.changes[1], at=14.0))
    )
    assert check(early, old.trajectories or old.seed).holds


def test_who_stands_where_something_falls_cannot_go_on() -> None:
    with pytest.raises(SeedingError, match=r"no way to go on after 6 s: room:1:1: bob\.start"):
        planned("  - {at: 6, obstacle: {rectangle: [6, 3.5, 8, 5]}}")
