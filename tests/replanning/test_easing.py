"""Agents that start too near each other."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.pair_clearance import nearest_moments_of
from stplan.errors import SceneError, SeedingError
from stplan.files.csv_file import csv_bytes, read_csv
from stplan.planned import Plan
from stplan.planner import write_plan
from stplan.problem.continuation import curves_of
from stplan.problem.world_lines import WorldLines
from stplan.replanning.easing import easing_of
from stplan.replanning.execution import check, plan, seed
from stplan.scene import parse_scene

CROWD = """\
stplan: 1
name: crowd
horizon: 20
solver: {effort: quick}
overlap: ease
defaults: {radius: 0.4}
map: {rectangle: [-8, -6, 8, 6]}
agents:
  - {id: ann, start: [0, 0], goal: [5, 4]}
  - {id: bob, start: [0.3, 0], goal: [-5, -4]}
  - {id: cem, start: [0.3, 0], goal: [-5, 4], max_acceleration: 0.5, max_speed: 1.5}
  - {id: dan, start: [1.2, 0], goal: [5, -4]}
  - {id: eve, start: [-7.5, 0], goal: [5, 0]}
"""
ROOM = """\
stplan: 1
name: room
horizon: 20
solver: {effort: quick}
map: {rectangle: [-1, -1, 11, 9]}
overlap: ease
defaults: {radius: 0.4}
agents:
  - {id: ann, start: [0, 4], goal: [10, 4]}
  - {id: bob, start: [10, 4.3], goal: [0, 4.3]}
"""


def distance(lines: WorldLines, one: str, other: str, begin: float, end: float) -> float:
    """The least distance of two agents between two times."""
    curves = curves_of(lines)
    times = np.union1d(np.linspace(begin, end, 2001), [begin, end])
    places = [
        np.column_stack([np.interp(times, curves[a][:, 2], curves[a][:, x]) for x in range(2)])
        for a in (one, other)
    ]
    return float(np.hypot(*(places[0] - places[1]).T).min())


@pytest.fixture(scope="module")
def apart() -> Plan:
    return plan(parse_scene(CROWD))


def test_they_go_apart_and_are_certified_from_then_on(apart) -> None:
    assert apart.exit_status == 0
    assert apart.certificate.holds
    eased = apart.certificate.eased
    assert {one.who for one in eased} == {("ann", "bob"), ("ann", "cem"), ("bob", "cem")}
    for one in eased:
        assert one.clear is not None
        assert 0.0 < one.clear < 3.0
        assert distance(apart.trajectories, *one.who, 0.0, one.clear) < 0.8
        assert distance(apart.trajectories, *one.who, one.clear + 1e-6, 20.0) > 0.8
    assert "BEFORE" in apart.certificate.summary
    assert len(apart.report.as_dict()["certificate"]["eased"]["rows"]) == 3
    others = nearest_moments_of(apart.trajectories, np.full(5, 20.0), np.array([[0, 4], [2, 3]]))
    assert (others.distance > 0.8).all()


def test_they_are_in_their_places_from_the_start(apart, tmp_path) -> None:
    scene = parse_scene(CROWD)
    for lines in (apart.trajectories, apart.seed, seed(scene).seed):
        assert lines.agent_ids == tuple(one.id for one in scene.agents)
        for agent, curve in zip(scene.agents, lines.curves(), strict=True):
            assert tuple(curve[0]) == (*agent.start, 0.0)
            assert tuple(curve[-1, :2]) == agent.goal
    write_plan(apart, tmp_path)
    again = check(scene, read_csv(tmp_path / "trajectories.csv"))
    assert again.holds
    assert again.as_dict() == apart.certificate.as_dict()
    assert csv_bytes(plan(scene).trajectories) == csv_bytes(apart.trajectories)


def test_who_comes_back_breaks_its_promise(apart) -> None:
    curves = curves_of(apart.trajectories)
    curves["bob"] = np.array([[0.3, 0, 0], [3, 0, 2], [0.3, 0, 9], [-5, -4, 20.0]])
    curves["ann"] = np.array([[0.0, 0, 0], [0, 0, 9.5], [5, 4, 20.0]])
    lines = WorldLines.from_curves(list(curves), list(curves.values()))
    found = check(parse_scene(CROWD), lines)
    assert any(one.startswith("ann and bob: 0.") for one in found.violations)
    curves["bob"] = np.array([[0.3, 0, 0], [0.3, 0, 9.5], [5.3, 4, 20.0]])
    lines = WorldLines.from_curves(list(curves), list(curves.values()))
    scene = parse_scene(CROWD.replace("goal: [-5, -4]", "goal: [5.3, 4], after_arrival: vanish"))
    found = check(scene, lines)
    assert any("ann and bob" in one and "never clear" in one for one in found.violations)


def test_without_being_asked_they_are_refused() -> None:
    with pytest.raises(SceneError, match=r"agents\[1\]\.start: is 0\.3 m from the start of 'ann'"):
        parse_scene(CROWD.replace("overlap: ease\n", ""))


def test_whoever_is_clear_is_planned_as_ever() -> None:
    text = ROOM.replace("overlap: ease\n", "")
    assert easing_of(parse_scene(ROOM)) is None
    old, new = plan(parse_scene(text)), plan(parse_scene(ROOM))
    assert csv_bytes(old.trajectories) == csv_bytes(new.trajectories)
    assert "eased" not in new.report.as_dict()["certificate"]


def test_where_there_is_no_room_it_is_said() -> None:
    text = CROWD.replace("[-8, -6, 8, 6]", "[-0.5, -0.5, 0.9, 0.5]").partition("  - {id: cem")[0]
    text = text.replace("[5, 4]", "[0, 0]").replace("[-5, -4]", "[0.3, 0], after_arrival: vanish")
    with pytest.raises(SeedingError, match="ann, bob: no room nearby to ease them apart"):
        plan(parse_scene(text))


def test_walls_are_kept_from_while_they_go_apart() -> None:
    text = CROWD.replace("[-8, -6, 8, 6]", "[-8, -0.5, 8, 6]").replace("-4]", "2]")
    scene = parse_scene(text)
    found = plan(scene)
    assert found.certificate.holds
    assert len(found.certificate.walls) == 5
    assert min(one.clearance for one in found.certificate.walls) > 0.0


EVENTS = {
    "a newcomer": "  - {at: 6, add: {id: sam, start: [3.1, 4.3], goal: [2, 0]}}",
    "who grows": "  - {at: 9.5, set: {defaults.radius: 0.6}}",
}


@pytest.mark.parametrize("name", EVENTS)
def test_at_events_they_go_apart_too(name: str) -> None:
    scene = parse_scene(ROOM + f"events:\n{EVENTS[name]}\n")
    found = plan(scene)
    assert found.certificate.holds
    (eased,) = found.certificate.eased
    at = scene.changes[0].at
    assert at < eased.clear < at + 3.0
    again = check(scene, found.trajectories)
    assert again.holds
    old = curves_of(plan(parse_scene(ROOM)).trajectories)
    for who, curve in curves_of(found.trajectories).items():
        if who in old:
            past = old[who][old[who][:, 2] < at]
            np.testing.assert_array_equal(curve[: len(past)], past)


def test_who_broke_down_stays_where_it_is() -> None:
    scene = parse_scene(
        ROOM + "events:\n  - {at: 6, agent: ann, delay: 4}\n"
        "  - {at: 6, add: {id: sam, start: [3.1, 4.3], goal: [2, 0]}}\n"
    )
    found = plan(scene)
    assert found.certificate.holds
    assert [one.who for one in found.certificate.eased] == [("ann", "sam")]
    times = np.linspace(6, 10, 9)
    ann = curves_of(found.trajectories)["ann"]
    assert np.ptp(np.interp(times, ann[:, 2], ann[:, 0])) < 1e-9


def test_what_is_played_has_no_plan_to_part_in() -> None:
    with pytest.raises(SceneError, match="overlap: is for plans"):
        parse_scene(
            ROOM.replace("radius: 0.4", "radius: 0.4, max_speed: 1, perception: {radius: 4}")
        )
