"""Terms over contacts are pure functions: whatever was asked before, the answer is the same."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.contacts.contact_term import ContactTerm
from stplan.costs.contacts.rod_candidates import RodCandidates
from stplan.costs.contacts.smooth_minimum import SmoothMinimum
from stplan.costs.contacts.wall_candidates import AllEdges
from stplan.costs.terms import collision
from stplan.costs.terms.grouping import Grouping
from stplan.geometry.contacts import measure
from tests.derivatives.samples import (
    EDGES,
    RODS,
    sample_collision,
    sample_interactions,
    sample_knots,
    sample_wall,
)


def terms() -> dict[str, ContactTerm]:
    return {
        "collision": sample_collision(1.5, None),
        "smooth collision": sample_collision(1.5, SmoothMinimum(8.0)),
        "endless collision": sample_collision(np.inf, SmoothMinimum(8.0)),
        "sparse collision": sample_collision(np.inf, SmoothMinimum(8.0, "stepped", 0.2)),
        "wall": sample_wall(1.5, None),
        "smooth wall": sample_wall(1.5, SmoothMinimum(8.0)),
        "endless wall": sample_wall(np.inf, SmoothMinimum(8.0)),
        "grouping": Grouping(sample_knots(), RODS, sample_interactions(), 3.0),
    }


def walk(length: int = 12) -> list[FloatArray]:
    rng = np.random.default_rng(8)
    knots = [sample_knots()]
    for _ in range(length):
        step = rng.normal(size=knots[-1].shape) * [0.1, 0.03, 0.05]
        knots.append(knots[-1] + step)
    return knots


def answers(term: ContactTerm, knots: FloatArray) -> list[FloatArray]:
    return [
        np.array([term.value(knots), term.least_clearance(knots)]),
        term.gradient(knots),
        term.gauss_newton_hessian(knots),
        term.hessian(knots),
    ]


def same(left: list[FloatArray], right: list[FloatArray]) -> bool:
    # Contacts too light to weigh may or may not be in a smooth minimum's list.
    return all(np.allclose(a, b, rtol=1e-12, atol=1e-13) for a, b in zip(left, right, strict=True))


@pytest.mark.parametrize("name", terms())
def test_answers_do_not_depend_on_what_was_asked_before(name: str) -> None:
    term = renewed = terms()[name]
    places = walk()
    finite = {term.value(knots) for knots in places} - {np.inf}
    assert len(finite) > 5
    for knots in [*places, *places[::-1], places[0], places[-1]]:
        renewed = renewed.renewed(knots)
        assert same(answers(renewed, knots), answers(terms()[name], knots))
        assert same(answers(term, knots), answers(terms()[name], knots))
    assert renewed is not term


@pytest.mark.parametrize("name", terms())
def test_renewing_where_nothing_moved_changes_nothing(name: str) -> None:
    term = terms()[name]
    assert term.renewed(sample_knots()) is term
    assert term.renewed(sample_knots() + 1e-3) is term


def test_contacts_that_miss_the_structure_are_stale_once_they_are_felt() -> None:
    term = sample_collision(0.4, None)
    knots = sample_knots()
    assert not term.is_stale(knots)
    # The first agent crosses over to where the second has been far from it.
    nearer = knots.copy()
    nearer[:6, 1] = 0.45
    nearer[:6, 2] = knots[6:12, 2][::-1]
    assert np.isfinite(term.value(nearer))
    assert term.value(nearer) > 0
    assert term.is_stale(nearer)
    # What it misses is missing from the Hessian alone.
    gradient = term.gradient(nearer)
    step = np.random.default_rng(2).normal(size=knots.shape)
    change = term.value(nearer + 1e-6 * step) - term.value(nearer - 1e-6 * step)
    assert change / 2e-6 == pytest.approx(float((gradient * step).sum()), rel=1e-5)
    assert not sample_wall(0.4, None).is_stale(nearer), "walls have room for every segment"


def test_the_endless_logarithm_of_the_smooth_minimum_is_that_over_all_segments() -> None:
    alpha, interactions = 60.0, sample_interactions()
    term = sample_collision(np.inf, SmoothMinimum(alpha))
    candidates = RodCandidates(RODS, interactions.collides, np.full((3, 3), np.inf))
    for knots in walk():
        every = candidates.find(knots, 0.0)
        distance = measure(RODS.positions(knots), every.points).distance
        total = 0.0
        for key, low, high in zip(every.keys, every.starts, every.starts[1:], strict=False):
            a, b = divmod(int(key), 3)
            sharpness = term.sharpness[key]
            smooth = -np.log(np.exp(-sharpness * distance[low:high]).sum()) / sharpness
            clearance = smooth - interactions.distance[a, b]
            weight = 0.7 * interactions.collision_weight[a, b]
            total += np.inf if clearance <= 0 else -weight * np.log(clearance)
        assert len(every.points) > len(term.renewed(knots).contacts.points)
        assert term.value(knots) == pytest.approx(total, rel=1e-12)


def test_the_endless_logarithm_at_walls_is_that_over_all_edges() -> None:
    term = sample_wall(np.inf, SmoothMinimum(8.0))
    brute = sample_wall(np.inf, SmoothMinimum(8.0), AllEdges(len(EDGES)))
    far = sample_knots() * [0.05, 0.05, 1.0] + [0.4, 0.4, 0.0]
    for knots in [*walk(), far]:
        assert same(answers(term, knots)[:2], answers(brute, knots)[:2])


def test_of_many_knots_the_structure_is_narrower_and_all_else_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wide, knots = sample_collision(1.5, None), sample_knots()
    monkeypatch.setattr(collision, "MANY_KNOTS", len(knots))
    narrow = sample_collision(1.5, None)
    assert len(narrow.gauss_newton_structure()[0]) < len(wide.gauss_newton_structure()[0])
    assert narrow.value(knots) == wide.value(knots)
    assert (narrow.gradient(knots) == wide.gradient(knots)).all()
    # All that is felt now has its room.
    assert not narrow.is_stale(knots)
    assert np.isclose(narrow.hessian(knots).sum(), wide.hessian(knots).sum(), rtol=1e-12)
