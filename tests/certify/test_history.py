"""What was executed while the world changed, on hand-made curves whose outcome is known."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.certificate import Certificate
from stplan.certify.history import certify_history, rest_certificate
from stplan.certify.motion import motion_peaks
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import spaces_of
from stplan.scene import parse_scene
from stplan.scene.model import Scene

AHEAD = [[0, 0, 0], [8, 0, 8]]
ASIDE = [[0, 6, 0], [8, 6, 8]]


def changing(*events: str, ann: str = "", sam: str = "", top: str = "") -> Scene:
    """Ann goes along y = 0 and Sam along y = 6, both of radius 0.5 m, while `events` happen."""
    entries = "".join(f"  - {{{event}}}\n" for event in events)
    return parse_scene(
        f"stplan: 1\nhorizon: 20\ndefaults: {{radius: 0.5}}\n{top}agents:\n"
        f"  - {{id: ann, start: [0, 0], goal: [8, 0], {ann}}}\n"
        f"  - {{id: sam, start: [0, 6], goal: [8, 6], {sam}}}\nevents:\n{entries}"
    )


def check(scene: Scene, **curves: list[list[float]]) -> Certificate:
    """The certificate of what was executed."""
    lines = WorldLines.from_curves(
        list(curves), [np.array(one, dtype=float) for one in curves.values()]
    )
    return certify_history(scene, spaces_of(scene), lines)


def test_everybody_ends_where_the_last_word_says() -> None:
    scene = changing("at: 3, agent: ann, goal: [8, 3]")
    turned = [[0, 0, 0], [3, 0, 3], [8, 3, 9]]
    assert check(scene, ann=turned, sam=ASIDE).holds
    assert check(scene, ann=AHEAD, sam=ASIDE).violations == (
        "ann: ends at (8.0, 0.0), not at (8.0, 3.0)",
    )


def test_walls_block_while_they_stand() -> None:
    def spill(begin: float) -> Scene:
        return changing(
            f"at: {begin}, obstacle: {{rectangle: [3, -1, 5, 1]}}, until: {begin + 2}",
            top="map: {rectangle: [-2, -2, 10, 8]}\n",
        )

    assert check(spill(6), ann=AHEAD, sam=ASIDE).holds
    found = check(spill(2.25), ann=AHEAD, sam=ASIDE)
    (sentence,) = found.violations
    assert sentence.startswith("ann: leaves the free space at t = 4.25 s")
    # The tightest of all times is named: of Sam the wall that always stands.
    gaps = {spot.who: spot.clearance for spot in found.walls}
    assert gaps["sam",] == pytest.approx(1.5)


def test_those_who_come_and_go_keep_clear_while_they_are_there() -> None:
    arrival = "at: 2, add: {id: eve, start: [6, -3], goal: [6, 3]}"
    crossing, later = [[6, -3, 2], [6, 3, 8]], [[6, -3, 2], [6, -3, 5], [6, 3, 12]]
    scene = changing(arrival)
    assert check(scene, ann=AHEAD, sam=ASIDE, eve=later).holds
    near = check(scene, ann=AHEAD, sam=ASIDE, eve=crossing)
    assert near.violations[0].startswith("ann and eve: 0.707107 m apart at t = 5.5 s")
    early = [[6, -3, 1], [6, -3, 5], [6, 3, 12]]
    assert check(scene, ann=AHEAD, sam=ASIDE, eve=early).violations == (
        "eve: starts at (6.0, -3.0, 1.0), not at (6.0, -3.0, 2.0)",
    )
    assert check(scene, ann=AHEAD, sam=ASIDE).violations == ("eve: has no trajectory",)


def test_those_who_are_removed_start_as_they_were_to_and_are_gone_in_time() -> None:
    scene = changing("at: 5, remove: ann")
    assert check(scene, ann=[[0, 0, 0], [5, 0, 5]], sam=ASIDE).holds
    assert check(scene, ann=AHEAD, sam=ASIDE).violations == (
        "ann: is there after 5 s, when it is removed",
    )
    assert check(scene, ann=[[1, 0, 0], [5, 0, 5]], sam=ASIDE).violations == (
        "ann: starts at (1.0, 0.0, 0.0), not at (0.0, 0.0, 0.0)",
    )
    assert check(scene, ann=[[0, 0, 0], [2e9, 0, 5]], sam=ASIDE).violations == (
        "ann: a coordinate or time is beyond 1e+09",
    )


@pytest.mark.parametrize(
    ("curve", "said"),
    [
        ([[0, 0, 0]], "ann: needs at least two finite knots whose times increase"),
        ([[0, 0, 0], [8, 0, 0]], "ann: needs at least two finite knots whose times increase"),
        (
            [[0, 0, 0], [5, 0, 5], [6, 0, 4], [8, 0, 8]],
            "ann: needs at least two finite knots whose times increase",
        ),
        ([[0, 0, 0], [np.nan, 0, 8]], "ann: needs at least two finite knots whose times increase"),
    ],
)
def test_what_is_no_curve_is_refused(curve, said) -> None:
    assert check(changing("at: 5, remove: ann"), ann=curve, sam=ASIDE).violations == (said,)


def test_strangers_are_refused() -> None:
    scene = changing("at: 5, remove: ann")
    found = check(scene, ann=AHEAD, sam=ASIDE, bob=[[0, 3, 0], [8, 3, 8]])
    assert found.violations == ("bob: is not in the scene",)
    assert (found.ignored_pairs, found.ignored_walls, found.pairs) == (0, 0, ())


def test_of_spots_equally_tight_the_first_is_named() -> None:
    # Side by side all the way; the world changes for somebody else in between.
    scene = changing("at: 4, add: {id: eve, start: [0, -9], goal: [8, -9]}")
    found = check(scene, ann=AHEAD, sam=ASIDE, eve=[[0, -9, 4], [8, -9, 12]])
    assert found.holds
    (spot,) = (one for one in found.pairs if one.who == ("ann", "sam"))
    assert (spot.clearance, spot.time) == (pytest.approx(5.0), 0.0)


def test_who_has_arrived_is_in_the_way_of_what_happens_later() -> None:
    turned = "at: 12, agent: sam, goal: [8, -3]"
    moved = [*ASIDE, [8, 6, 12], [8, -3, 18]]
    (sentence,) = check(changing(turned), ann=AHEAD, sam=moved).violations
    assert sentence.startswith("ann and sam: 0 m apart at t = 16 s")
    vanished = changing(turned, ann="after_arrival: vanish")
    assert check(vanished, ann=AHEAD, sam=moved).holds


def test_speed_is_held_to_the_limit_of_then() -> None:
    scene = changing("at: 4, agent: ann, max_speed: 0.5", ann="max_speed: 1")
    slower = [[0, 0, 0], [4, 0, 4], [8, 0, 12]]
    found = check(scene, ann=slower, sam=ASIDE)
    assert found.holds
    assert {(peak.agent, peak.limit) for peak in found.limits} == {("ann", "speed")}
    assert check(scene, ann=AHEAD, sam=ASIDE).violations == (
        "ann: speed 1 m/s at t = 4 s; at most 0.5 m/s is allowed",
    )
    (peak,) = check(scene, ann=[[0, 0, 0], [8, 0, 20]], sam=ASIDE).limits
    assert (peak.allowed, peak.reached, peak.time) == (0.5, 0.4, 10.0)
    hasty = [[0, 0, 0], [4, 0, 3], [8, 0, 12]]
    (sentence,) = check(scene, ann=hasty, sam=ASIDE).violations
    assert sentence == "ann: speed 1.33333 m/s at t = 1.5 s; at most 1 m/s is allowed"


@pytest.mark.parametrize("late", [0.0, 64.0])
def test_motion_is_judged_as_where_nothing_happens(late: float) -> None:
    rng = np.random.default_rng(6)
    scene = parse_scene(
        f"stplan: 1\nhorizon: {20 + late}\nagents:\n  - {{id: ann, start: [0, 0], goal: [8, 0], "
        f"start_time: {late}, max_speed: 9, max_acceleration: 90}}\n"
        f"  - {{id: sam, start: [0, 60], goal: [8, 60], start_time: {late}}}\n"
        f"events: [{{at: {late + 4.5}, agent: sam, goal: [8, 60]}}]\n"
    )
    other = np.array([[0, 60, late], [8, 60, late + 8.0]])
    for count in (2, 3, 5, 9, 17):
        times = late + np.round(np.cumsum(rng.uniform(0.5, 1.0, count)), 3)
        x = np.concatenate([[0.0], rng.normal(size=count - 2) * 2.0, [8.0]])
        curve = np.column_stack([x, np.zeros(count), times])
        curve[:, 2] += late - times[0]
        found = check(scene, ann=curve.tolist(), sam=other.tolist()).limits
        expected = motion_peaks(scene.agents[0], curve)
        for one, two in zip(found, expected, strict=True):
            assert (one.limit, one.allowed) == (two.limit, two.allowed)
            assert one.reached == pytest.approx(two.reached)
            assert one.time == pytest.approx(two.time)


def test_a_limit_may_come_on_the_way() -> None:
    scene = changing("at: 4, agent: ann, max_speed: 0.5")
    slower = [[0, 0, 0], [4, 0, 4], [8, 0, 12]]
    (peak,) = check(scene, ann=slower, sam=ASIDE).limits
    assert (peak.agent, peak.limit, peak.allowed, peak.reached) == ("ann", "speed", 0.5, 0.5)
    (sentence,) = check(scene, ann=AHEAD, sam=ASIDE).violations
    assert sentence == "ann: speed 1 m/s at t = 4 s; at most 0.5 m/s is allowed"


def test_rounding_is_that_of_the_widest_world() -> None:
    near = changing("at: 3, agent: ann, goal: [8, 3]")
    turned = [[0, 0, 0], [3, 0, 3], [8, 3, 9]]
    small = check(near, ann=turned, sam=ASIDE).rounding
    wide = changing("at: 3, add: {id: eve, start: [900, 0], goal: [990, 0]}", "at: 6, remove: eve")
    eve = [[900, 0, 3], [990, 0, 6]]
    assert check(wide, ann=AHEAD, sam=ASIDE, eve=eve).rounding > 20.0 * small


def test_a_delay_cuts_the_very_first_segment_short() -> None:
    walk = [[0, 0, 0], [0.05, 0, 0.1], [0.05, 0, 3.1]]
    walk += [[0.05 + 0.5 * k, 0, 3.1 + k] for k in range(1, 16)]
    walk += [[8, 0, 20]]
    scene = changing("at: 0.1, agent: ann, delay: 3", ann="max_acceleration: 11")
    assert check(scene, ann=walk, sam=ASIDE).violations == ()


def test_a_delay_stops_at_once_and_nothing_else_does() -> None:
    # Whole seconds at 1 m/s from rest to rest, with half speed in the first and last.
    def walk(stop: float) -> list[list[float]]:
        knots = [[0, 0, 0], [0.5, 0, 1]]
        knots += [[0.5 + k, 0, 1.0 + k] for k in range(1, 4)]
        knots += [[3.5, 0, 4.25], [3.5, 0, stop], [3.75, 0, stop + 0.5]]
        knots += [[3.75 + k, 0, stop + 0.5 + k] for k in range(1, 5)]
        return [*knots, [8, 0, stop + 5.5]]

    own = "max_acceleration: 1.1"
    stopped = changing("at: 4, agent: ann, delay: 3", ann=own)
    assert check(stopped, ann=walk(7.0), sam=ASIDE).holds
    other = changing("at: 4, agent: sam, delay: 3", ann=own)
    (sentence,) = check(other, ann=walk(7.0), sam=[*ASIDE[:1], [8, 6, 12]]).violations
    assert sentence.startswith("ann: acceleration ")


def test_what_a_delay_cuts_short_was_planned_to_last_longer() -> None:
    # Steps of half a metre a second, a second long but for the one that is cut off at 3.1 s.
    speeds = [(0.25, 1), (0.75, 1), (0.75, 1), (0.25, 0.1), (0, 3), (0.25, 1), *[(0.75, 1)] * 7]
    speeds += [(0.5, 1), (0.225, 1)]
    times = np.cumsum([0.0, *(lasts for _, lasts in speeds)])
    x = np.cumsum([0.0, *(speed * lasts for speed, lasts in speeds)])
    x[-1] = 8.0
    walk = [[place, 0, time] for place, time in zip(x.tolist(), times.tolist(), strict=True)]
    own = "max_acceleration: {}"
    stopped = changing(f"at: {float(times[4])!r}, agent: ann, delay: 3", ann=own.format(0.6))
    assert check(stopped, ann=walk, sam=ASIDE).holds
    strict = changing(f"at: {float(times[4])!r}, agent: ann, delay: 3", ann=own.format(0.45))
    assert not check(strict, ann=walk, sam=ASIDE).holds


def test_who_has_arrived_before_it_is_removed_comes_to_rest_there() -> None:
    own = "max_acceleration: 1.4"
    stands = [[0, 0, 0], [0.5, 0, 1], [1.5, 0, 2], [2.5, 0, 3]]
    scene = changing("at: 2.5, agent: ann, goal: [2.5, 0]", "at: 6, remove: ann", ann=own)
    (sentence,) = check(scene, ann=stands, sam=ASIDE).violations
    assert sentence.startswith("ann: acceleration 2.66667 m/s2 at t = 3 s")


def test_a_removed_agent_need_not_brake() -> None:
    own = "max_acceleration: 1.4"
    moving = [[0, 0, 0], [0.5, 0, 1], [1.5, 0, 2], [2.5, 0, 3]]
    assert check(changing("at: 3, remove: ann", ann=own), ann=moving, sam=ASIDE).holds
    kept = changing("at: 3, agent: ann, goal: [2.5, 0]", ann=own)
    (sentence,) = check(kept, ann=moving, sam=ASIDE).violations
    assert sentence == ("ann: acceleration 2.66667 m/s2 at t = 3 s; at most 1.4 m/s2 is allowed")


def test_whether_the_old_plan_stays_clear_is_told_of_those_who_go_on() -> None:
    scene = changing(
        "at: 2, obstacle: {rectangle: [4, -1, 6, 1]}", top="map: {rectangle: [-2, -2, 10, 8]}\n"
    )
    (change,), (_, space) = scene.changes, spaces_of(scene)
    both = {"ann": np.array(AHEAD, dtype=float), "sam": np.array(ASIDE, dtype=float)}
    found = rest_certificate(change, space, both)
    assert found is not None
    assert not found.holds
    alone = rest_certificate(change, space, {"sam": both["sam"]})
    assert alone is not None
    assert alone.holds
    assert rest_certificate(change, space, {}) is None
