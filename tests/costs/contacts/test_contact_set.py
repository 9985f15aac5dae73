"""Contact sets along walks: renewed ones know all that fresh ones and brute force know."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.arrays import FloatArray, IntArray
from stplan.costs.contacts.contact_set import Candidates, ContactList, ContactSet, distinct
from stplan.costs.contacts.nearest_candidates import NearestCandidates
from stplan.costs.contacts.rod_candidates import MANY, RodCandidates, brute_force
from stplan.costs.contacts.smooth_minimum import NEGLIGIBLE
from stplan.costs.contacts.wall_candidates import AllEdges, WallCandidates
from stplan.geometry.contacts import measure
from tests.derivatives.samples import (
    BOUNDARY,
    CORNERS,
    EDGES,
    LAYOUT,
    RODS,
    sample_knots,
)

REACH = 1.1
SKIN = 0.3
PAIRS = ~np.eye(3, dtype=bool)


def rods(sharpness: float | None = None) -> RodCandidates:
    alpha = None if sharpness is None else np.full(9, sharpness)
    return RodCandidates(RODS, PAIRS, np.full((3, 3), REACH), sharpness=alpha)


def walls(sharpness: float | None = None) -> WallCandidates:
    alpha = None if sharpness is None else np.full(3, sharpness)
    reach = np.full(3, REACH)
    return WallCandidates(LAYOUT, LAYOUT.segment, CORNERS, EDGES, reach, BOUNDARY, alpha)


def friends() -> NearestCandidates:
    return NearestCandidates(RODS, np.array([[0, 1], [0, 2]]), 3, np.full(2, 30.0), tails=False)


CASES: dict[str, tuple[Candidates, Candidates]] = {
    "rods": (rods(), replace(rods(), broad_phase=brute_force)),
    "smooth rods": (rods(20.0), replace(rods(20.0), broad_phase=brute_force)),
    "walls": (walls(), replace(walls(), search=AllEdges(len(EDGES)))),
    "smooth walls": (walls(20.0), replace(walls(20.0), search=AllEdges(len(EDGES)))),
}


def walk(step: float, share: float, length: int = 40) -> list[FloatArray]:
    """Knots that wander, a `share` of them by `step` at a time, the others by much less."""
    rng = np.random.default_rng(4)
    knots = [sample_knots()]
    for _ in range(length):
        far = rng.random(LAYOUT.num_knots) < share
        size = np.where(far, step, 0.05 * step)[:, None]
        knots.append(knots[-1] + size * rng.normal(size=knots[-1].shape))
    return knots


def felt(contacts: ContactSet, knots: FloatArray) -> IntArray:
    """What is nearer than the reach of those around, in the list's order, keys included."""
    listed = contacts.contacts
    distance = measure(contacts.candidates.positions(knots), listed.points).distance
    keep = distance < REACH
    return np.column_stack([listed.keys[listed.members], listed.points])[keep]


@pytest.mark.parametrize("share", [0.1, 1.0])
@pytest.mark.parametrize("case", CASES)
def test_renewed_equals_fresh_equals_brute_force(case: str, share: float) -> None:
    candidates, brute = CASES[case]
    contacts = ContactSet.fresh(candidates, sample_knots(), SKIN)
    renewals, found = 0, 0
    for knots in walk(0.1, share):
        before = contacts
        contacts = contacts.renewed(knots)
        renewals += contacts is not before
        assert not contacts.moved(knots).any()
        fresh = ContactSet.fresh(candidates, knots, SKIN)
        known = felt(contacts, knots)
        assert np.array_equal(known, felt(fresh, knots))
        everyone = felt(ContactSet.fresh(brute, knots, SKIN), knots)
        assert {tuple(row) for row in known.tolist()} == {tuple(row) for row in everyone.tolist()}
        found += len(known)
    assert renewals > 5
    assert found > 50


def test_friends_far_apart_are_listed_with_all_that_weigh() -> None:
    candidates = friends()
    apart = sample_knots()
    apart[LAYOUT.offsets[1] :, 1] += 40.0
    contacts = ContactSet.fresh(candidates, apart, SKIN)
    assert set(contacts.contacts.keys) == {1, 2}
    own = RODS.segments[: len(LAYOUT.segment)]
    renewals = 0
    for knots in (one + apart - sample_knots() for one in walk(0.1, 0.5)):
        before = contacts
        contacts = contacts.renewed(knots)
        renewals += contacts is not before
        listed = {tuple(points) for points in contacts.contacts.points.tolist()}
        for a, b in candidates.pairs:
            mine, others = (own[LAYOUT.agent_of_segment == agent] for agent in (a, b))
            pairs = np.array([[*one, *other] for one in mine for other in others])
            distance = measure(candidates.positions(knots), pairs).distance
            weighty = pairs[distance < distance.min() + NEGLIGIBLE / 30.0]
            assert len(weighty)
            assert {tuple(points) for points in weighty.tolist()} <= listed
    assert renewals > 5


def test_a_list_is_mended_only_around_who_moved() -> None:
    candidates = rods()
    contacts = ContactSet.fresh(candidates, sample_knots(), SKIN)
    knots = sample_knots()
    knots[3, 0] += SKIN
    moved = contacts.moved(knots)
    assert 0 < moved.mean() < MANY
    mended = contacts.renewed(knots)
    assert np.array_equal(mended.around, knots)
    assert mended.skin == contacts.skin
    assert contacts.renewed(sample_knots()) is contacts
    # The list it was made from is as it was: a value.
    assert np.array_equal(contacts.around, sample_knots())


def test_distant_contacts_weigh_nothing_and_are_not_listed() -> None:
    every = ContactSet.fresh(rods(), sample_knots(), 0.01).contacts
    weighty = ContactSet.fresh(rods(400.0), sample_knots(), 0.01).contacts
    assert set(every.keys) == set(weighty.keys) == {1, 5}
    assert 2 <= len(weighty.points) < len(every.points)


def test_reaches_without_end_list_everybody() -> None:
    endless = replace(rods(), reach=np.full((3, 3), np.inf))
    contacts = ContactSet.fresh(endless, sample_knots(), SKIN)
    # 5, 5 and 6 segments, and one tail.
    assert len(contacts.contacts.points) == 5 * 5 + 5 * 7 + 5 * 7
    far = replace(walls(), reach=np.full(3, np.inf))
    # Every knot to every edge, every segment to every corner.
    assert len(ContactSet.fresh(far, sample_knots(), SKIN).contacts.points) == 19 * 8 + 16 * 8


def test_distinct_codes_are_sorted() -> None:
    assert distinct(np.array([7, 3, 7, 1, 3], dtype=np.int64)).tolist() == [1, 3, 7]
    assert distinct(np.empty(0, dtype=np.int64)).tolist() == []


def test_contacts_are_grouped_in_the_order_they_came_in() -> None:
    points = np.arange(20).reshape(5, 4)
    grouped = ContactList.grouped(points, np.array([5, 2, 5, 9, 2]))
    assert grouped.keys.tolist() == [2, 5, 9]
    assert grouped.starts.tolist() == [0, 2, 4, 5]
    assert grouped.members.tolist() == [0, 0, 1, 1, 2]
    assert grouped.points[:, 0].tolist() == [4, 16, 0, 8, 12]
    kept = grouped.kept(np.array([True, True, False, False, True]))
    assert kept.keys.tolist() == [2, 9]
    assert kept.points[:, 0].tolist() == [4, 16, 12]
