"""Limits of motion, visits and meetings on hand-made curves whose outcome is known."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.certificate import Certificate, certify
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

FAR = [[0, 9, 0], [8, 9, 10]]


def check(own: str, curve: list, other: list = FAR, more: str = "") -> Certificate:
    """The certificate of a walker with keys `own` and another one."""
    scene = parse_scene(
        "stplan: 1\nhorizon: 10\nagents:\n"
        f"  - {{id: a, start: [0, 0], goal: [8, 0], {own}}}\n"
        f"  - {{id: b, start: [0, 9], goal: [8, 9]}}\n{more}"
    )
    curves = [np.array(one, dtype=float) for one in (curve, other)]
    return certify(scene, None, WorldLines.from_curves(["a", "b"], curves))


def test_speed_of_every_segment() -> None:
    curve = [[0, 0, 0], [2, 0, 4], [8, 0, 7]]
    found = check("max_speed: 2.0", curve)
    assert found.holds
    assert found.limits[0].reached == 2.0
    assert found.as_dict()["limits"]["rows"] == [["a", "speed", 2.0, 2.0, 5.5]]
    broken = check("max_speed: 1.9", curve)
    assert broken.violations == ("a: speed 2 m/s at t = 5.5 s; at most 1.9 m/s is allowed",)


@pytest.mark.parametrize(("excess", "kept"), [(0.8e-9, True), (1.2e-9, False)])
def test_limits_count_as_kept_up_to_a_billionth(excess: float, kept: bool) -> None:
    curve = [[0, 0, 0], [2, 0, 4], [8, 0, 7]]
    assert check(f"max_speed: {2.0 / (1.0 + excess)!r}", curve).holds == kept


def even(lengths: list[float], times: list[float]) -> list[list[float]]:
    """A curve along x."""
    return [[x, 0, t] for x, t in zip(np.cumsum([0.0, *lengths]).tolist(), times, strict=True)]


@pytest.mark.parametrize(
    ("curve", "greatest", "when"),
    [
        # From rest: the first segment's middle is half its duration away.
        (even([1.0] * 8, np.arange(9.0).tolist()), 2.0, 0),
        # Between two segments: over the time between their middles.
        (even([0.25, 1.0, 1.0, 1.5, 2.0, 1.5, 0.5, 0.25], np.arange(9.0).tolist()), 1.0, 6),
        (even([0.1, 0.4, 2.5, 2.5, 2.0, 0.4, 0.1], [0, 1, 2, 4, 5, 6, 7, 8]), 1.6, 6),
        ([[0, 0, 0], [7, 0, 9], [8, 0, 9.5]], 8.0, 9.5),
        # Long segments hide nothing: over an eighth of the whole time at most.
        ([[0, 0, 0], [8, 0, 8]], 1.0, 0),
        ([[0, 0, 0], [1, 0, 4], [7, 0, 6], [8, 0, 10]], 2.75 / 1.25, 4),
    ],
)
def test_acceleration_from_rest_to_rest(curve, greatest, when) -> None:
    found = check("max_acceleration: 8.0", curve)
    assert found.holds
    assert found.limits[0].reached == pytest.approx(greatest)
    assert found.limits[0].time == when
    (sentence,) = check(f"max_acceleration: {0.99 * greatest}", curve).violations
    assert sentence.startswith("a: acceleration ")


@pytest.mark.parametrize(
    ("x", "dwell", "kept"),
    [
        (4, 3.4, True),
        (4, 3.5, False),
        (8, 1.7, True),
        (8, 1.8, False),
        (0, 1.7, True),
        (0, 1.8, False),
    ],
)
def test_a_wide_agent_stays_while_it_is_within_its_tolerance(
    x: int, dwell: float, kept: bool
) -> None:
    # A millionth of its radius: 2 m. At 1 m/s, 1 m beside the point, it is within for 2 sqrt(3) s, at
    # an end of its way for half of it.
    scene = parse_scene(
        "stplan: 1\nhorizon: 20\nagents:\n  - {id: a, start: [0, 0], goal: [8, 0], radius: 2.0e+6, "
        f"waypoints: [{{at: [{x}, 1], dwell: {dwell}}}]}}\n"
    )
    curve = np.array([[0, 0, 0], [8, 0, 8.0]])
    assert certify(scene, None, WorldLines.from_curves(["a"], [curve])).holds == kept


def test_accelerations_are_the_same_whenever_they_happen() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 110\nagents:\n"
        "  - {id: a, start: [0, 0], goal: [8, 0], start_time: 100, max_acceleration: 8}\n"
    )
    curve = np.array([[0, 0, 100], [1, 0, 104], [7, 0, 106], [8, 0, 110.0]])
    (peak,) = certify(scene, None, WorldLines.from_curves(["a"], [curve])).limits
    assert peak.reached == pytest.approx(2.75 / 1.25)
    assert peak.time == 104


def test_an_acceleration_cannot_be_hidden_in_long_segments() -> None:
    # From rest to rest, 8 m in 4 s take at least 4 * 8 / 4^2 = 2 m/s2, however few knots say so.
    for knots in (2, 3, 5, 9, 41):
        times = np.linspace(0.0, 4.0, knots)
        speed = np.minimum(times[1:] + times[:-1], 8.0 - times[1:] - times[:-1])
        way = np.concatenate([[0.0], np.cumsum(speed * np.diff(times))])
        way *= 8.0 / way[-1]
        curve = [[x, 0, t] for x, t in zip(way.tolist(), times.tolist(), strict=True)]
        curve[-1][0] = 8
        assert not check("max_acceleration: 1.95", curve).holds
    # A jump of velocity between two long segments.
    jump = [[0, 0, 0], [0.5, 0, 5], [8, 0, 10]]
    (sentence,) = check("max_acceleration: 0.6", jump).violations
    assert sentence.startswith("a: acceleration 1.2 m/s2 at t = 10 s; at most 0.6 m/s2 is allowed")
    assert sentence.endswith("give it more knots")
    # So many knots as plans have are not judged more strictly than by the middles of their segments.
    times = np.linspace(0.0, 10.0, 20)
    smooth = 8.0 * (3.0 * (times / 10.0) ** 2 - 2.0 * (times / 10.0) ** 3)
    curve = [[x, 0, t] for x, t in zip(smooth.tolist(), times.tolist(), strict=True)]
    assert check("max_acceleration: 0.48", curve).limits[0].reached == pytest.approx(0.46, abs=0.02)


def test_only_of_long_segments_it_is_said_that_more_knots_would_tell() -> None:
    jerky = even([0.25, 1.0, 1.0, 1.5, 2.0, 1.5, 0.5, 0.25], np.arange(9.0).tolist())
    (sentence,) = check("max_acceleration: 0.9", jerky).violations
    assert sentence == "a: acceleration 1 m/s2 at t = 6 s; at most 0.9 m/s2 is allowed"
    assert not check("max_acceleration: 1.1", jerky).limits[0].coarse


STAY = [[0, 0, 0], [4, 0, 3], [4, 0, 6], [8, 0, 10]]


@pytest.mark.parametrize(
    ("visit", "kept"),
    [
        ("dwell: 3", True),
        ("dwell: 3.01", False),
        ("window: [2, 4], dwell: 1", True),
        ("window: [2, 4], dwell: 1.1", False),
        ("window: [5, 9]", True),
        ("window: [6.1, 9]", False),
        ("window: [1, 2.9]", False),
    ],
)
def test_visits(visit: str, kept: bool) -> None:
    found = check(f"waypoints: [{{at: [4, 0], {visit}}}]", STAY)
    assert found.holds == kept
    if not kept:
        assert "waypoint 1 (4.0, 0.0) in order" in found.violations[0]


def test_what_a_visit_was_to_be_is_said_in_full() -> None:
    assert check("waypoints: [{at: [4, 0], window: [2, 4], dwell: 1.1}]", STAY).violations == (
        "a: does not pass waypoint 1 (4.0, 0.0) in order between 2 and 4 s, staying there for 1.1 s",
    )


def test_visits_follow_one_another() -> None:
    two = "waypoints: [{{at: [4, 0], dwell: {}}}, {{at: [4, 0], dwell: 2}}]"
    assert check(two.format(1.0), STAY).holds
    assert "waypoint 2" in check(two.format(1.1), STAY).violations[0]


@pytest.mark.parametrize(("over", "kept"), [(5e-9, True), (5e-8, False)])
def test_times_count_as_kept_up_to_a_billionth_of_the_whole(over: float, kept: bool) -> None:
    # Of ten seconds: 1e-8 s, after the 3e-7 s in which it is within a millionth of its radius, at 1 m/s.
    dwell = 2.0 + 3e-7 + over
    assert (
        check(f"waypoints: [{{at: [4, 0], window: [4, 9], dwell: {dwell!r}}}]", STAY).holds == kept
    )


@pytest.mark.parametrize(("dwell", "kept"), [(2.9999, True), (3.0001, False)])
def test_late_in_time_a_stay_is_judged_as_precisely(dwell: float, kept: bool) -> None:
    late = 1e6
    scene = parse_scene(
        f"stplan: 1\nhorizon: {late + 10}\nagents:\n  - {{id: a, start: [0, 0], goal: [8, 0], "
        f"start_time: {late}, waypoints: [{{at: [4, 0], dwell: {dwell}}}]}}\n"
    )
    curve = np.array(STAY, dtype=float) + np.array([0.0, 0.0, late])
    assert certify(scene, None, WorldLines.from_curves(["a"], [curve])).holds == kept


def test_a_short_stop_is_no_long_one() -> None:
    slow = [[0, 0, 0], [4, 0, 3], [4.1, 0, 6], [8, 0, 10]]
    assert not check("waypoints: [{at: [4, 0], dwell: 1}]", slow).holds


MEET = "pairs: [{{between: [a, b], meet: {{within: {}}}}}]"


def test_meetings_are_at_a_common_instant() -> None:
    up = [[0, 0, 0], [4, 4, 5], [8, 0, 10]]
    down = [[0, 9, 0], [4, 5, 5], [8, 9, 10]]
    found = check("radius: 0.3", up, down, MEET.format("1.0"))
    assert found.holds
    assert found.meetings[0].distance == pytest.approx(1.0)
    assert found.meetings[0].time == pytest.approx(5.0)
    assert found.meetings[0].place == pytest.approx((4.0, 4.5))
    # The same path at another time is no meeting.
    late = [[0, 9, 0], [4, 5, 8], [8, 9, 10]]
    (sentence,) = check("radius: 0.3", up, late, MEET.format("1.0")).violations
    assert sentence == (
        "a and b: come no nearer than 2.91548 m, at t = 5 s, (3.25, 5.25); "
        "they should meet within 1 m"
    )


@pytest.mark.parametrize(("apart", "met"), [(1e-10, True), (1e-8, False)])
def test_meetings_count_up_to_rounding(apart: float, met: bool) -> None:
    up = [[0, 0, 0], [4, 4, 5], [8, 0, 10]]
    down = [[0, 9, 0], [4, 5 + apart, 5], [8, 9, 10]]
    assert check("radius: 0.3", up, down, MEET.format("1.0")).holds == met


def test_meetings_between_knots_and_windows() -> None:
    up = [[0, 0, 0], [8, 8, 8], [8, 0, 10]]
    down = [[0, 9, 0], [8, 1, 8], [8, 9, 10]]
    off = "pairs: [{between: [a, b], collide: false, meet: {within: 1.5%s}}]"
    found = check("radius: 0.3", up, down, off % "")
    assert found.meetings[0].distance == pytest.approx(0.0, abs=1e-9)
    assert found.meetings[0].time == pytest.approx(4.5)
    assert not check("radius: 0.3", up, down, off % ", window: [0, 3]").holds
    assert check("radius: 0.3", up, down, off % ", window: [0, 4]").holds
    assert check("radius: 0.3", up, down, off % ", window: [9, 20]").holds
    assert not check("radius: 0.3", up, down, off % ", window: [6, 8]").holds
    # However finely the same motion is written down.
    fine = np.linspace(0.0, 10.0, 41)
    denser = [
        np.column_stack(
            [*(np.interp(fine, *np.array(one).T[[2, axis]]) for axis in (0, 1)), fine]
        ).tolist()
        for one in (up, [[0, 9.3, 0], [8, 1.3, 8], [8, 9, 10]])
    ]
    (spot,) = check("radius: 0.3", denser[0], [[0, 9, 0], *denser[1][1:]], off % "").meetings
    assert spot.time == pytest.approx(4.65)
    assert spot.distance == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("within", "met"), [(3.0, True), (2.9, False)])
def test_a_meeting_may_be_of_a_single_instant(within: float, met: bool) -> None:
    # The one leaves at the very moment at which the other comes, 3 m from it.
    scene = parse_scene(
        "stplan: 1\nhorizon: 10\nagents:\n"
        "  - {id: a, start: [0, 0], goal: [8, 0], max_time: 4, after_arrival: vanish}\n"
        "  - {id: b, start: [8, 3], goal: [0, 3], start_time: 4}\n"
        f"pairs: [{{between: [a, b], meet: {{within: {within}}}}}]\n"
    )
    curves = [
        np.array(one, dtype=float) for one in ([[0, 0, 0], [8, 0, 4]], [[8, 3, 4], [0, 3, 10]])
    ]
    found = certify(scene, None, WorldLines.from_curves(["a", "b"], curves))
    assert found.holds == met
    assert (found.meetings[0].time, found.meetings[0].place) == (4.0, (8.0, 1.5))


@pytest.mark.parametrize(("aside", "kept"), [(6e-7, True), (9e-7, False)])
def test_far_away_places_are_told_apart_as_far_as_coordinates_can(aside: float, kept: bool) -> None:
    # At 9e8 m coordinates are 1.2e-7 m apart; four of these count, and a millionth of the radius.
    scene = parse_scene(
        "stplan: 1\nhorizon: 10\nagents:\n  - {id: a, start: [899999996, 0], goal: [900000004, 0], "
        f"waypoints: [[900000000, {aside!r}]]}}\n"
    )
    curve = np.array([[899999996, 0, 0], [900000004, 0, 8.0]])
    assert certify(scene, None, WorldLines.from_curves(["a"], [curve])).holds == kept


def test_who_vanishes_before_is_not_met() -> None:
    gone = check(
        "radius: 0.3, after_arrival: vanish, max_time: 4",
        [[0, 0, 0], [8, 0, 4]],
        FAR,
        "pairs: [{between: [a, b], meet: {within: 20, window: [2, 9]}}]",
    )
    assert gone.holds
    assert gone.meetings[0].time <= 4.0


def test_the_first_segment_has_the_velocity_at_the_start() -> None:
    curve = [[0, 0, 0], [1, 0.5, 2], [8, 0, 10]]
    assert check("start_velocity: [0.5, 0.25]", curve).holds
    found = check("start_velocity: [0.5, 0.2501]", curve)
    assert found.violations == (
        "a: starts with velocity (0.5, 0.25) m/s, not with (0.5, 0.2501) m/s",
    )


@pytest.mark.parametrize(("vy", "kept"), [(0.25, True), (0.2501, False)])
def test_velocities_at_the_start_are_the_same_anywhere_and_at_any_time(
    vy: float, kept: bool
) -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 60\nagents:\n  - {id: a, start: [30, -20], goal: [38, -20], "
        f"start_time: 50, start_velocity: [0.5, {vy}]}}\n"
    )
    curve = np.array([[30, -20, 50], [31, -19.5, 52], [38, -20, 60.0]])
    assert certify(scene, None, WorldLines.from_curves(["a"], [curve])).holds == kept


def test_acceleration_from_motion() -> None:
    """The velocity before the start counts as that at rest does: 0.5 m/s more within half a second."""
    curve = even([1.0] * 8, np.arange(9.0).tolist())
    found = check("max_acceleration: 8.0, start_velocity: [0.5, 0]", curve).limits[0]
    assert (found.reached, found.time) == (2.0, 8.0)
    found = check("max_acceleration: 8.0, start_velocity: [-0.5, 0]", curve).limits[0]
    assert (found.reached, found.time) == (3.0, 0.0)


def test_the_velocity_at_the_start_is_kept_as_long_as_asked() -> None:
    """With a limit of acceleration, too."""
    curve = even([1.0] * 8, np.arange(9.0).tolist())
    asked = "start_velocity: [1, 0], max_acceleration: 8"
    assert check(f"{asked}, start_duration: 1", curve).holds
    (sentence,) = check(f"{asked}, start_duration: 1.1", curve).violations
    assert sentence.endswith("not with (1.0, 0.0) m/s for 1.1 s")
