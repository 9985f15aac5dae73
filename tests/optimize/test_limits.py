"""Limits of motion, visits, meetings and friendships: from the scene to certified trajectories."""

from __future__ import annotations

import numpy as np
import pytest

import stplan
from stplan.certify.certificate import certify
from stplan.errors import SeedingError
from stplan.optimize.restoration import asks_for_more, restore
from stplan.planner import Plan
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene import parse_scene
from stplan.seeding.portfolio import find_seed
from stplan.world import build_free_space

HEAD = "stplan: 1\nhorizon: 20\n"
PRESSED = "preferred_time: 1, weights: {arrival: 100}"
WALLS = (
    "map:\n  rectangle: [-1, -1, 14, 10]\n  obstacles:\n"
    "    - {rectangle: [4, -1, 5, 8]}\n    - {rectangle: [8, 1, 9, 10]}\n"
)
FAR = (
    "agents:\n  - {id: a, start: [0, 0], goal: [9, 0]}\n  - {id: b, start: [0, 7], goal: [9, 7]}\n"
)


def planned(text: str) -> Plan:
    """The plan of a scene whose seed and trajectories hold all that it asks for."""
    scene = parse_scene(HEAD + text, overrides=["solver.outer_iterations=2"])
    plan = stplan.plan(scene)
    assert plan.exit_status == 0
    assert plan.certificate.holds
    assert certify(scene, build_free_space(scene), plan.seed).holds
    return plan


def alone(own: str) -> Plan:
    return planned(
        f"agents:\n  - {{id: a, start: [0, 0], goal: [9, 0], {own}}}\nsolver: {{mu: 1e-4}}"
    )


def arrival(plan: Plan) -> float:
    assert plan.trajectories is not None
    return float(plan.trajectories.curve(0)[-1, 2])


def test_at_a_speed_limit_nobody_arrives_before_distance_over_speed() -> None:
    assert 6.0 <= arrival(alone(f"max_speed: 1.5, {PRESSED}")) <= 6.0 * (1 + 1e-3)


def test_at_an_acceleration_limit_the_fastest_way_is_bang_bang() -> None:
    plan = alone(f"max_acceleration: 1.0, {PRESSED}")
    assert arrival(plan) == pytest.approx(6.0, rel=0.02)
    assert plan.trajectories is not None
    curve = plan.trajectories.curve(0)
    middle = 0.5 * (curve[1:, 2] + curve[:-1, 2])
    speed = np.diff(curve[:, 0]) / np.diff(curve[:, 2])
    # Half the way as fast as it can, half the way as slow as it must.
    expected = np.minimum(middle, arrival(plan) - middle)
    assert speed == pytest.approx(expected, abs=0.05)


def test_both_limits_together() -> None:
    # 1.5 m/s is reached after 1.5 s and 1.125 m, and left as late.
    plan = alone(f"max_acceleration: 1.0, max_speed: 1.5, {PRESSED}")
    assert arrival(plan) == pytest.approx(9 / 1.5 + 1.5, rel=0.03)


def test_a_generous_limit_changes_nothing() -> None:
    free, limited = alone("radius: 0.3"), alone("max_speed: 9.0")
    assert free.trajectories is not None
    assert limited.trajectories is not None
    assert np.array_equal(free.trajectories.knots, limited.trajectories.knots)


def test_many_agents_in_each_others_way_keep_their_limits() -> None:
    plan = planned(
        "agents:\n  - {pattern: circle, id: w, count: 5, circle: {center: [0, 0], radius: 5},\n"
        "     max_speed: 0.7, max_acceleration: 0.25}\n"
    )
    assert len(plan.certificate.limits) == 10
    # The limits are felt: without them agents start at full speed.
    assert max(peak.reached / peak.allowed for peak in plan.certificate.limits) > 0.9
    assert plan.report.as_dict()["certificate"]["limits"]["rows"][1][:2] == ["w-1", "acceleration"]


def test_visits_on_time_and_as_long_as_asked() -> None:
    plan = planned(
        "agents:\n  - {id: a, start: [0, 0], goal: [9, 0], max_acceleration: 1.0,\n"
        "     waypoints: [[2, 1], {at: [4, 1], window: [10, 14], dwell: 3},\n"
        "                 {at: [8, 2], window: [15, 16]}]}\n"
    )
    assert plan.trajectories is not None
    curve = plan.trajectories.curve(0)
    there = curve[(curve[:, :2] == [4, 1]).all(axis=1), 2]
    assert there[0] >= 10.0
    assert there[-1] <= 14.0
    assert np.ptp(there) >= 3.0


def test_a_visit_on_the_goal_before_the_end() -> None:
    planned(
        "agents:\n  - {id: a, start: [0, 0], goal: [9, 0],"
        " waypoints: [{at: [9, 0], window: [0, 12], dwell: 2}]}\n"
    )


@pytest.mark.parametrize("window", ["", ", window: [4, 6]"])
def test_meetings_are_held(window: str) -> None:
    plan = planned(FAR + f"pairs: [{{between: [a, b], meet: {{within: 1.0{window}}}}}]")
    (spot,) = plan.certificate.meetings
    # No nearer than they must: they would rather go straight.
    assert 0.9 < spot.distance <= 1.0
    if window:
        assert 4.0 <= spot.time <= 6.0


def test_meetings_around_walls_and_with_a_third() -> None:
    plan = planned(
        WALLS + "agents:\n  - {id: a, start: [0, 0], goal: [12, 0], max_speed: 4.0}\n"
        "  - {id: b, start: [6.5, 0], goal: [6.5, 5]}\n  - {id: c, start: [12, 9], goal: [12, 3]}\n"
        "pairs:\n  - {between: [a, b], meet: {within: 0.9}}\n"
        "  - {between: [b, c], meet: {within: 0.9, window: [2, 18]}}\n"
    )
    assert all(spot.distance <= 0.9 for spot in plan.certificate.meetings)


def test_three_meet_one_by_one() -> None:
    plan = planned(
        "agents:\n  - {pattern: circle, id: w, count: 3, circle: {center: [0, 0], radius: 8}}\n"
        "groups: [{members: [w], meet: {within: 1.2}}]\n"
    )
    assert len(plan.certificate.meetings) == 3


def test_who_moves_as_told_is_met_on_its_way() -> None:
    plan = planned(
        "agents:\n  - {id: bus, path: [[0, 5, 0], [20, 5, 20]]}\n"
        "  - {id: a, start: [0, 0], goal: [5, 0], max_speed: 2}\n"
        "pairs: [{between: [a, bus], meet: {within: 1.0}}]\n"
    )
    assert plan.certificate.meetings[0].who == ("bus", "a")


def friends_apart(grouping: str) -> float:
    plan = planned(FAR + grouping)
    assert plan.trajectories is not None
    curves = list(plan.trajectories.curves())
    times = np.linspace(0, 20, 201)
    at = [np.column_stack([np.interp(times, c[:, 2], c[:, x]) for x in range(2)]) for c in curves]
    return float(np.hypot(*(at[0] - at[1]).T).min())


def test_friends_come_together_from_afar() -> None:
    # Ten times as far as any barrier reaches.
    assert friends_apart("") == pytest.approx(7.0, abs=1e-3)
    weak = friends_apart("groups: [{members: [a, b], grouping: 0.05}]")
    strong = friends_apart("groups: [{members: [a, b], grouping: 5.0}]")
    assert 1.0 < weak < 6.0
    assert 0.6 < strong < 0.8


@pytest.mark.parametrize(
    ("own", "words"),
    [
        (
            "max_speed: 0.4",
            "a cannot reach its goal by 20 s: its way is at least 9 m long, and at 0.4",
        ),
        ("max_acceleration: 0.04", "at least 9 m long, too long from rest to rest at 0.04 m/s2"),
        (
            "max_speed: 1, waypoints: [{at: [4, 0], dwell: 12}]",
            "a cannot reach its goal by 20 s: its way is at least 9 m long, and at 1 m/s that takes "
            "until 21 s",
        ),
        (
            "max_speed: 1, waypoints: [{at: [4, 0], window: [0, 3.5]}]",
            "a cannot have visited waypoint 1 by 3.5 s: its way is at least 4 m",
        ),
    ],
)
def test_what_is_proven_to_be_impossible(own: str, words: str) -> None:
    scene = parse_scene(HEAD + f"agents:\n  - {{id: a, start: [0, 0], goal: [9, 0], {own}}}\n")
    with pytest.raises(SeedingError) as refused:
        stplan.plan(scene)
    assert str(refused.value).startswith("no curves keep the limits of the scene: ")
    assert words in str(refused.value)


def test_the_proof_goes_around_walls() -> None:
    agents = "agents:\n  - {id: a, start: [0, 0], goal: [12, 0], radius: 0.3, max_speed: %s}\n"
    # Over the first wall and under the second: 22.6 m from tangent to tangent of the corners.
    with pytest.raises(SeedingError, match=r"its way is at least 22\.\d+ m long"):
        stplan.plan(parse_scene(HEAD + WALLS + agents % 1.0))
    planned(WALLS + agents % 1.3)


def test_what_is_not_found_says_what_is_missing() -> None:
    # Both must be at the same spot at the same time, which nothing proves impossible here.
    scene = parse_scene(
        HEAD + "agents:\n"
        "  - {id: a, start: [0, 0], goal: [9, 0], waypoints: [{at: [4, 0], window: [5, 6], dwell: 0.9}]}\n"
        "  - {id: b, start: [4, 5], goal: [4, -5], waypoints: [{at: [4, 0.1], window: [5, 6], dwell: 0.9}]}\n"
    )
    with pytest.raises(SeedingError) as refused:
        stplan.plan(scene)
    assert "hold their certificate" in str(refused.value) or "no collision-free" in str(
        refused.value
    )
    assert refused.value.exit_status == 3


def test_scenes_that_ask_for_nothing_more_keep_their_seed() -> None:
    scene = parse_scene(HEAD + FAR)
    problem = PlanningProblem.from_scene(scene, None)
    assert not asks_for_more(problem)
    seed = find_seed(problem, progress=lambda line: None)
    restored = restore(problem, seed.world_lines, progress=lambda line: None, stop=lambda: False)
    assert restored is seed.world_lines


def test_the_same_bytes_again() -> None:
    text = FAR.replace("goal: [9, 0]", "goal: [9, 0], max_acceleration: 0.5")
    text += "pairs: [{between: [a, b], meet: {within: 1.0}}]"
    first, second = planned(text), planned(text)
    assert first.trajectories is not None
    assert second.trajectories is not None
    assert first.trajectories.knots.tobytes() == second.trajectories.knots.tobytes()
