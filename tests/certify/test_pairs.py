"""What is said of pairs: all of them in small scenes, the tightest and a proven rest in large ones."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.certify import pairs as pairs_module
from stplan.certify.certificate import certify
from stplan.certify.pair_clearance import nearest_moments
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import PairRule, Weights
from tests.certify.crowds import scene_of, walkers


def spread(count: int, gap: float) -> WorldLines:
    """Walkers in file, `gap` (m) apart and ever further."""
    x = np.cumsum(gap + 1e-3 * np.arange(count))
    curves = [np.array([[at, 0.0, 0.0], [at, 9.0, 10.0]]) for at in x]
    return WorldLines.from_curves([f"w{a}" for a in range(count)], curves)


@pytest.mark.parametrize("stays", [False, True])
def test_a_large_scene_is_judged_as_a_small_one(monkeypatch, stays: bool) -> None:
    rng = np.random.default_rng(1)
    lines = walkers(120, rng)
    rules = (
        PairRule(tuple(range(0, 120, 7)), tuple(range(120)), distance=1.5),
        PairRule((3, 4, 5), tuple(range(60)), collide=False),
        PairRule((4,), (20, 21), collide=True, distance=0.3),
    )
    scene = scene_of(lines, rng.uniform(0.2, 0.4, 120), stays=stays, pairs=rules)
    small = certify(scene, None, lines)
    assert small.unlisted is None
    monkeypatch.setattr(pairs_module, "LISTED", 100)
    monkeypatch.setattr(pairs_module, "TIGHTEST", 100)
    large = certify(scene, None, lines)
    assert large.unlisted is not None
    assert large.ignored_pairs == small.ignored_pairs > 0
    assert large.num_pairs + large.ignored_pairs == 120 * 119 // 2
    expected = sorted(small.pairs, key=lambda spot: spot.clearance)
    assert list(large.pairs) == expected[:100]
    assert large.smallest == small.smallest
    assert large.unlisted.clearance <= expected[100].clearance
    assert large.unlisted.clearance == pytest.approx(expected[100].clearance, abs=1e-9)
    assert not large.holds
    named = [one for one in large.violations if " m apart " in one]
    assert set(named) <= set(small.violations)
    rest = len(small.violations) - len(named)
    assert (
        large.violations[-1] == f"{rest} further pairs of agents are too near each other"
        or not rest
    )
    others = large.as_dict()["pairs"]["others"]
    assert others == {"pairs": large.unlisted.pairs, "clearance_above": large.unlisted.clearance}
    assert "others" not in small.as_dict()["pairs"]


# Of an odd number one is in the middle.
@pytest.mark.parametrize("count", [40, 41])
def test_the_tightest_pair_is_found_however_far_apart_all_are(monkeypatch, count: int) -> None:
    monkeypatch.setattr(pairs_module, "LISTED", 10)
    lines = spread(count, 700.0)
    found = certify(scene_of(lines, np.full(count, 0.3)), None, lines)
    assert found.holds
    assert found.smallest is not None
    assert found.smallest.who == ("w0", "w1")
    assert found.smallest.clearance == pytest.approx(700.001 - 0.6)
    assert found.unlisted is not None
    assert found.unlisted.clearance > 0.0
    assert len(found.pairs) + found.unlisted.pairs == count * (count - 1) // 2


@pytest.mark.parametrize("tightest", range(1, 29))
def test_listed_pairs_and_the_rest_are_all_pairs(monkeypatch, tightest: int) -> None:
    monkeypatch.setattr(pairs_module, "LISTED", 10)
    monkeypatch.setattr(pairs_module, "TIGHTEST", tightest)
    lines = spread(8, 0.7)
    found = certify(scene_of(lines, np.full(8, 0.3)), None, lines)
    assert found.holds
    assert found.unlisted is not None
    assert found.num_pairs == 28
    assert len(found.pairs) <= tightest
    assert found.unlisted.clearance >= found.pairs[-1].clearance - 1e-9


def test_those_who_are_never_there_together_have_no_tightest_spot(monkeypatch) -> None:
    monkeypatch.setattr(pairs_module, "LISTED", 10)
    lines = spread(8, 1.0)
    for a in range(8):
        lines.knots[lines.offsets[a] : lines.offsets[a + 1], 2] += 20.0 * a
    found = certify(scene_of(lines, np.full(8, 0.3)), None, lines)
    assert found.holds
    assert found.smallest is None
    assert found.unlisted is not None
    assert found.unlisted.pairs == 28


def test_nobody_who_ignores_everybody_is_looked_at(monkeypatch) -> None:
    monkeypatch.setattr(pairs_module, "LISTED", 0)
    lines = spread(5, 0.1)
    found = certify(scene_of(lines, np.full(5, 0.3), weights=Weights(collision=0.0)), None, lines)
    assert found.holds
    assert found.ignored_pairs == 10


def two(gap: float, shift: float, radius: float = 0.3) -> tuple[bool, tuple[str, ...]]:
    """Whether two who pass each other so far apart hold their certificate, `shift` m up north."""
    lines = WorldLines.from_curves(
        ["a", "b"],
        [
            np.array([[5e5, shift, 0.0], [5e5 + 40.0, shift, 30.0]]),
            np.array([[5e5 + 40.0, shift + gap, 0.0], [5e5, shift + gap, 30.0]]),
        ],
    )
    found = certify(scene_of(lines, np.full(2, radius)), None, lines)
    return found.holds, found.violations


def test_far_up_north_millimetres_still_count() -> None:
    shift = 1e7
    assert two(0.6 + 1e-6, shift)[0]
    assert not two(0.6 - 1e-6, shift)[0]


def test_what_rounding_could_feign_is_no_clearance() -> None:
    # 0.75 and the sum of the radii are exact; the bound is 1e-12 m for a walk of 40 m.
    quarter = 0.375
    assert two(0.75 + 2.0**-20, 0.0, quarter)[0]
    holds, violations = two(0.75 + 2.0**-41, 0.0, quarter)
    assert not holds
    (sentence,) = violations
    assert "0.75 m is needed, by more than rounding (" in sentence
    assert "0.7500000000005 m apart" in sentence
    assert "more than 0.75 m" in two(0.75, 0.0, quarter)[1][0]


def test_agents_that_meet_out_of_this_world_are_refused() -> None:
    for place in (1e17, 2e9):
        lines = WorldLines.from_curves(
            ["a", "b"],
            [
                np.array([[place, 0.0, 0.0], [place, 8.0, 10.0]]),
                np.array([[place, 8.0, 0.0], [place, 0.0, 10.0]]),
            ],
        )
        found = certify(scene_of(lines, np.full(2, 0.3)), None, lines)
        assert set(found.violations) == {
            "a: a coordinate or time is beyond 1e+09",
            "b: a coordinate or time is beyond 1e+09",
        }


def test_a_crowd_of_a_million_pairs_is_judged_as_by_looking_at_each() -> None:
    rng = np.random.default_rng(7)
    lines = walkers(1500, rng)
    radii = rng.uniform(0.25, 0.4, 1500)
    found = certify(scene_of(lines, radii), None, lines)
    leaves = lines.knots[lines.offsets[1:] - 1, 2]
    every = nearest_moments(lines, leaves, ~np.eye(1500, dtype=bool))
    clearance = np.sort(every.distance - radii[every.pairs].sum(axis=1))
    assert len(found.pairs) == 1000
    assert [spot.clearance for spot in found.pairs] == clearance[:1000].tolist()
    assert found.unlisted is not None
    assert found.unlisted.pairs == 1500 * 1499 // 2 - 1000
    assert found.unlisted.clearance <= clearance[1000]
    too_near = int((clearance <= 0.0).sum())
    assert too_near > 1000
    assert len(found.violations) == 1001
    assert found.violations[-1].startswith(f"{too_near - 1000} further pairs")
