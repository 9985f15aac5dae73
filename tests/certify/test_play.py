"""Scenes whose goals move, on hand-made curves whose outcome is known."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.certificate import Certificate
from stplan.certify.play import certify_play, first_within
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene
from stplan.world import build_free_space

FOX = "id: fox, start: [2, 5], goal: {pursue: hare, capture: 1.0}"
HARE = "id: hare, start: [6, 5], goal: {evade: fox}"
# At 2 m/s after 1 m/s and 4 m behind: within a metre after 3 s.
CHASE = [[2, 5, 0], [8, 5, 3], [8, 5, 6]]
CAUGHT = [[6, 5, 0], [9, 5, 3]]


def check(*agents: str, defaults: str = "", more: str = "", **curves: list) -> Certificate:
    """The certificate of `curves` by id."""
    entries = "".join(f"  - {{{agent}}}\n" for agent in agents)
    scene = parse_scene(
        "stplan: 1\nhorizon: 6\nmap: {rectangle: [0, 0, 20, 10]}\n"
        f"defaults: {{radius: 0.3, max_speed: 3{defaults}}}\nagents:\n{entries}{more}"
    )
    arrays = [np.array(curve, dtype=float) for curve in curves.values()]
    lines = WorldLines.from_curves(list(curves), arrays)
    return certify_play(scene, build_free_space(scene), lines)


def test_who_is_caught_leaves_at_that_moment() -> None:
    found = check(FOX, HARE, fox=CHASE, hare=CAUGHT)
    assert found.holds
    assert found.pairs[0].clearance == pytest.approx(1.0 - 0.6)
    assert {(peak.agent, peak.limit, peak.reached) for peak in found.limits} == {
        ("fox", "speed", 2.0), ("hare", "speed", 1.0),
    }  # fmt: skip


def test_who_leaves_earlier_was_caught_by_nobody() -> None:
    found = check(FOX, HARE, fox=CHASE, hare=[[6, 5, 0], [8, 5, 2]])
    assert found.violations == ("hare: leaves at 2 s, caught by nobody",)


@pytest.mark.parametrize("until", [3.5, 6.0])
def test_who_was_near_enough_is_there_no_longer(until: float) -> None:
    fox = [[2, 5, 0], [8.3, 5, 3.15], [11.15, 5, 6]]
    found = check(FOX, HARE, fox=fox, hare=[[6, 5, 0], [6 + until, 5, until]])
    (sentence,) = found.violations
    assert sentence == f"hare: is within 1 m of fox at 3 s, and there until {until:g} s"


def test_who_gets_away_stays_until_the_end() -> None:
    slow = [[2, 5, 0], [8, 5, 6]]
    assert check(FOX, HARE, fox=slow, hare=[[6, 5, 0], [12, 5, 6]]).holds


def test_any_pursuer_may_catch_but_only_while_it_is_there() -> None:
    wolf = "id: wolf, start: [14, 5], goal: {pursue: [fox, hare], capture: 1.0}"
    away = [[2, 5, 0], [2, 5, 6]]
    # The wolf comes from the other side, at 2 m/s: 8 m apart at first, a metre after 7 / 3 s.
    when = 7.0 / 3.0
    wait = [[14, 5, 0], [14 - 2 * when, 5, when], [14 - 2 * when, 5, 6]]
    caught = [[6, 5, 0], [6 + when, 5, when]]
    assert check(FOX, wolf, HARE, fox=away, wolf=wait, hare=caught).holds
    # The fox that would have caught the hare at 3 s was caught itself before.
    near = wolf.replace("[14, 5]", "[4, 5]")
    chased = "id: hare, start: [6, 5], goal: {evade: [fox, wolf]}"
    still = [[4, 5, 0], [4, 5, 6]]
    found = check(FOX, near, chased, fox=[[2, 5, 0], [3, 5, 0.5]], wolf=still, hare=CAUGHT)
    assert found.violations == ("hare: leaves at 3 s, caught by nobody",)


def test_who_catches_may_be_caught_at_the_same_moment() -> None:
    chased = "id: fox, start: [2, 5], goal: {pursue: hare, capture: 1.0}"
    wolf = "id: wolf, start: [1, 5], goal: {pursue: fox, capture: 1.0}"
    near = wolf.replace("[1, 5]", "[0.5, 5]")
    # Behind the fox by 1.5 m, then by 1 m when the fox is a metre behind the hare.
    after = [[0.5, 5, 0], [7, 5, 3], [7, 5, 6]]
    found = check(chased, near, HARE, fox=CHASE[:2], wolf=after, hare=CAUGHT)
    assert found.holds


def test_who_is_nobodys_prey_stays_until_the_end() -> None:
    owl = "id: owl, start: [2, 9], goal: [4, 9]"
    found = check(FOX, HARE, owl, fox=CHASE, hare=CAUGHT, owl=[[2, 9, 0], [4, 9, 4]])
    assert found.violations == ("owl: leaves at 4 s, caught by nobody",)
    stays = [[2, 9, 0], [4, 9, 4], [4, 9, 6]]
    assert check(FOX, HARE, owl, fox=CHASE, hare=CAUGHT, owl=stays).holds


def test_distances_and_speeds_count_as_ever() -> None:
    owl = "id: owl, start: [6, 1], goal: [6, 9]"
    across = [[6, 1, 0], [6, 4.6, 1.6], [6, 9, 6]]
    found = check(FOX, HARE, owl, fox=CHASE, hare=CAUGHT, owl=across)
    assert found.violations[0].startswith("fox and owl: ")
    fast = [[2, 5, 0], [2.25, 5, 1], [7.75, 5, 2.75], [7.75, 5, 6]]
    (sentence,) = check(FOX, HARE, fox=fast, hare=[[6, 5, 0], [8.75, 5, 2.75]]).violations
    assert sentence.startswith("fox: speed 3.14286 m/s at t = 1.875 s")
    wall = [[6, 5, 0], [6, 9.8, 4], [6, 9.8, 6]]
    away = [[2, 5, 0], [2, 5, 6]]
    (sentence,) = check(FOX, HARE, fox=away, hare=wall).violations
    assert "from a wall" in sentence


def test_all_that_is_wrong_is_said_where_nobody_has_to_keep_apart() -> None:
    free = "pairs: [{between: [all, all], collide: false}]\n"
    wall = [[6, 5, 0], [6, 9.8, 4]]
    found = check(FOX, HARE, more=free, fox=[[2, 5, 0], [2, 5, 6]], hare=wall)
    assert found.pairs == ()
    assert len(found.violations) == 2
    assert found.violations[1] == "hare: leaves at 4 s, caught by nobody"


def test_where_curves_begin_comes_first() -> None:
    found = check(FOX, HARE, fox=CHASE, hare=[[6, 5.5, 0], [8, 5, 2]])
    (sentence,) = found.violations
    assert sentence.startswith("hare: starts at (6.0, 5.5, 0.0), not at ")


@pytest.mark.parametrize(
    "curve",
    [
        [[6, 5, 0]],
        [[6, 5, 0], [np.nan, 5, 3]],
        [[6, 5, 0], [9, 5, np.inf]],
        [[6, 5, 0], [8, 5, 3], [9, 5, 3]],
        [[6, 5, 0], [8, 5, 3], [9, 5, 2]],
    ],
)
def test_of_what_is_no_curve_nothing_else_is_said(curve: list) -> None:
    sentence = "hare: needs at least two finite knots whose times increase"
    found = check(FOX, HARE, fox=CHASE, hare=curve)
    assert found == Certificate((sentence,), (), (), 0, 0)
    assert not found.holds


def test_everybody_has_a_curve() -> None:
    assert check(FOX, HARE, fox=CHASE).violations == ("hare: has no trajectory",)


def accelerated(last: float) -> list[list[float]]:
    """The hare's curve: ever faster by 0.2 m/s; of its segments the last but one takes a quarter second."""
    lasts = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 0.25, last])
    times = np.concatenate([[0.0], np.cumsum(lasts)])
    speeds = 0.1 + 0.2 * np.arange(len(lasts))
    x = 6.0 + np.concatenate([[0.0], np.cumsum(lasts * speeds)])
    return [[place, 5.0, time] for place, time in zip(x.tolist(), times.tolist(), strict=True)]


def chasing(curve: list[list[float]]) -> list[list[float]]:
    """A fox that waits where the hare comes to within a metre of it."""
    x, _, time = curve[-1]
    return [[x + 1.0, 5, 0], [x + 1.0, 5, time], [x + 1.0, 5, 6]]


@pytest.mark.parametrize("last", [0.25, 0.02])
def test_a_capture_cuts_a_segment_short_and_asks_for_no_rest(last: float) -> None:
    curve = accelerated(last)
    fox = chasing(curve)
    there = FOX.replace("[2, 5]", f"[{fox[0][0]!r}, 5]")
    found = check(there, HARE, defaults=", max_acceleration: 0.85", fox=fox, hare=curve)
    assert found.holds
    (peak,) = (one for one in found.limits if (one.agent, one.limit) == ("hare", "acceleration"))
    # A change of 0.2 m/s between the middles of two segments of a quarter second.
    assert peak.reached == pytest.approx(0.8)
    found = check(there, HARE, defaults=", max_acceleration: 0.75", fox=fox, hare=curve)
    assert [one.partition(" m/s2")[0][:18] for one in found.violations] == ["hare: acceleration"]


def test_who_is_not_caught_comes_to_rest() -> None:
    run = [[6, 5, 0], [12, 5, 6]]
    found = check(FOX, HARE, defaults=", max_acceleration: 1", fox=[[2, 5, 0], [2, 5, 6]], hare=run)
    (sentence,) = found.violations
    assert sentence.startswith("hare: acceleration ")


def test_when_offsets_come_near_first() -> None:
    rng = np.random.default_rng(8)
    seen = 0
    for _ in range(200):
        offsets = np.cumsum(rng.normal(size=(6, 2)) * 2.0, axis=0) + 2.0
        times = np.cumsum(rng.uniform(0.1, 2.0, 6))
        fine = np.linspace(times[0], times[-1], 40001)
        gap = np.hypot(*(np.interp(fine, times, offsets[:, x]) for x in range(2)))
        near = np.flatnonzero(gap <= 1.5)
        found = first_within(offsets, times, 1.5)
        if found is None:
            assert not len(near)
        else:
            seen += 1
            assert found == pytest.approx(fine[near[0]], abs=1e-3)
    assert 50 < seen < 150


def test_however_finely_offsets_are_written_down() -> None:
    times = np.array([0.0, 4.0])
    offsets = np.array([[-4.0, 0.3], [4.0, 0.5]])
    expected = first_within(offsets, times, 1.0)
    fine = np.linspace(0.0, 4.0, 101)
    denser = np.column_stack([np.interp(fine, times, offsets[:, x]) for x in range(2)])
    assert first_within(denser, fine, 1.0) == pytest.approx(expected)


def test_offsets_that_stand_still_or_lead_away() -> None:
    times = np.array([3.0, 5.0, 6.0])
    still = np.array([[2.0, 0.0], [2.0, 0.0], [0.0, 0.0]])
    assert first_within(still, times, 1.0) == pytest.approx(5.5)
    away = np.array([[2.0, 0.0], [3.0, 0.0], [9.0, 0.0]])
    assert first_within(away, times, 1.0) is None
    assert first_within(away, times, 2.0) == 3.0
    # It just touches.
    past = np.array([[-4.0, 1.0], [4.0, 1.0]])
    assert first_within(past, times[:2], 1.0) == pytest.approx(4.0)
    assert first_within(past, times[:2], 0.999) is None
