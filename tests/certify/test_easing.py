"""Agents that start too near each other, on hand-made curves whose outcome is known."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify.certificate import Certificate, certify
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

# Of radius 0.5 m, half a metre apart at first; Bob stands, Eve is far away.
BOB = [[0.5, 0, 0], [0.5, 0, 9]]
EVE = [[0, 5, 0], [4, 5, 9]]
AWAY = [[0, 0, 0], [-1, 0, 2], [-4, 0, 9]]


def check(ann: list, *, bob: list = BOB, own: str = "", more: str = "") -> Certificate:
    """The certificate of Ann, who starts too near to Bob."""
    goals = [f"[{curve[-1][0]}, {curve[-1][1]}]" for curve in (ann, bob)]
    scene = parse_scene(
        f"stplan: 1\nhorizon: 9\noverlap: ease\ndefaults: {{radius: 0.5}}\nagents:\n"
        f"  - {{id: ann, start: [0, 0], goal: {goals[0]}{own}}}\n"
        f"  - {{id: bob, start: [0.5, 0], goal: {goals[1]}}}\n"
        f"  - {{id: eve, start: [0, 5], goal: [4, 5]}}\n{more}"
    )
    curves = [np.array(one, dtype=float) for one in (ann, bob, EVE)]
    return certify(scene, None, WorldLines.from_curves(["ann", "bob", "eve"], curves))


def test_they_keep_apart_from_when_on_they_are() -> None:
    found = check(AWAY)
    assert found.holds
    (eased,) = found.eased
    assert (eased.who, eased.apart, eased.needed) == (("ann", "bob"), 0.5, 1.0)
    # Half a metre at half a metre a second.
    assert eased.clear == pytest.approx(1.0, abs=1e-5)
    assert (
        str(eased) == "ann and bob start 0.5 m apart, too near: clear from 1 s on (more than 1 m)"
    )
    assert {spot.who for spot in found.pairs} == {("ann", "bob"), ("ann", "eve"), ("bob", "eve")}
    (spot,) = (one for one in found.pairs if one.who == ("ann", "bob"))
    assert 0.0 < spot.clearance < 2e-6
    assert spot.time == pytest.approx(1.0, abs=1e-5)
    assert (found.ignored_pairs, len(found.pairs)) == (0, 3)


def test_who_comes_back_breaks_the_promise() -> None:
    back = [[0, 0, 0], [-2, 0, 2], [-0.25, 0, 4], [-4, 0, 9]]
    (sentence,) = check(back).violations
    assert sentence.startswith("ann and bob: 0.75 m apart at t = 4 s, ")
    assert "more than 1 m is needed" in sentence


def test_who_is_never_clear_is_named() -> None:
    near = [[0, 0, 0], [-0.25, 0, 9]]
    found = check(near, own=", after_arrival: vanish")
    assert found.violations == (
        "ann and bob start 0.5 m apart, too near: never clear (more than 1 m)",
    )
    assert found.eased[0].clear is None


def test_others_keep_their_distance_all_the_time() -> None:
    up = [[0, 0, 0], [1.75, 4.5, 4], [-4, 0, 9]]
    assert any(one.startswith("ann and eve: ") for one in check(up).violations)


def test_a_pair_that_does_not_collide_need_not_part() -> None:
    rule = "pairs: [{between: [ann, bob], collide: false}]\n"
    found = check([[0, 0, 0], [-0.25, 0, 9]], more=rule)
    assert found.holds
    assert found.eased == ()
    assert found.ignored_pairs == 1


def test_whoever_stands_may_be_left_by_one_who_has_arrived() -> None:
    # Both have arrived when they are clear: the last knot decides.
    arrives = [[0, 0, 0], [-0.6, 0, 3]]
    bob = [[0.5, 0, 0], [0.5, 0, 1]]
    found = check(arrives, bob=bob)
    assert found.holds
    assert found.eased[0].clear == pytest.approx(2.5, abs=1e-4)


def test_on_a_bent_way_apart_the_moment_is_exact() -> None:
    # At 1 m/s across: sqrt(0.25 + t^2) = 1.
    across = [[0, 0, 0], [0, -4, 4], [-4, -4, 9]]
    clear = check(across).eased[0].clear
    assert clear == pytest.approx(np.sqrt(0.75), abs=1e-5)


def test_who_leaves_before_they_are_clear_is_kept_from_no_longer() -> None:
    gone = [[0, 0, 0], [-0.25, 0, 3]]
    later = [[0.5, 0, 0], [0.5, 0, 5], [4, 0, 9]]
    found = check(gone, bob=later, own=", after_arrival: vanish")
    assert found.holds
    assert found.eased[0].clear is not None
    assert {spot.who for spot in found.pairs} == {("ann", "eve"), ("bob", "eve")}


def test_both_may_move_from_the_start() -> None:
    bob = [[0.5, 0, 0], [2.5, 0, 2], [4, 0, 9]]
    (eased,) = check([[0, 0, 0], [-2, 0, 2], [-4, 0, 9]], bob=bob).eased
    assert eased.apart == 0.5
    assert eased.clear == pytest.approx(0.25, abs=1e-5)


def test_every_pair_is_counted_once() -> None:
    scene = parse_scene(
        "stplan: 1\nhorizon: 9\noverlap: ease\ndefaults: {radius: 0.5}\nagents:\n"
        "  - {id: a, start: [0, 0], goal: [-4, 0]}\n  - {id: b, start: [0.5, 0], goal: [0.5, 0]}\n"
        "  - {id: c, start: [1, 0], goal: [5, 0]}\n  - {id: d, start: [0, 5], goal: [4, 5]}\n"
    )
    ends = {"a": [-4, 0], "b": [0.5, 0], "c": [5, 0], "d": [4, 5]}
    curves = [
        np.array([[*agent.start, 0], [*ends[agent.id], 9]], dtype=float) for agent in scene.agents
    ]
    found = certify(scene, None, WorldLines.from_curves(list(ends), curves))
    assert found.holds
    assert [one.who for one in found.eased] == [("a", "b"), ("a", "c"), ("b", "c")]
    assert found.ignored_pairs == 0
    assert len(found.pairs) == 6
