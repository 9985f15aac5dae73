"""Barriers and smooth minima against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.contacts.barrier import barrier
from stplan.costs.contacts.contact_set import ContactList
from stplan.costs.contacts.potential import (
    Coefficients,
    ContactBarriers,
    Potential,
    QuadraticPull,
    SmoothMinimumBarriers,
)
from stplan.costs.contacts.smooth_minimum import (
    SmoothMinimum,
    smooth_minimum,
    weighing_reach,
)

ONE = np.ones(1)


def summed(potential: Potential, *groups: list[float]) -> Coefficients:
    """What contacts at the distances of `groups` contribute."""
    keys = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    contacts = ContactList.grouped(np.zeros((len(keys), 4), dtype=np.int64), keys)
    distance: FloatArray = np.concatenate(groups)
    return potential.coefficients(distance, contacts)


@pytest.mark.parametrize("reach", [0.7, np.inf])
def test_barrier_derivatives_and_limits(reach: float) -> None:
    for z in (0.01, 0.2, 0.5, 0.69):
        step = 1e-6
        value, first, second = barrier(z, reach)
        assert first == pytest.approx(
            (barrier(z + step, reach)[0] - barrier(z - step, reach)[0]) / (2 * step), rel=1e-6
        )
        assert second == pytest.approx(
            (barrier(z + step, reach)[1] - barrier(z - step, reach)[1]) / (2 * step), rel=1e-5
        )
        assert value > 0 or reach == np.inf
        assert first < 0 < second


def test_clamped_barrier_vanishes_smoothly_at_its_range() -> None:
    for order in range(3):
        assert barrier(0.7, 0.7)[order] == 0
        assert abs(barrier(0.7 - 1e-7, 0.7)[order]) < 1e-5
    assert barrier(1e-9, 0.7)[0] == pytest.approx(-np.log(1e-9 / 0.7), rel=1e-6)


def test_smooth_minimum_underestimates_and_does_not_overflow() -> None:
    distance = np.array([1e5, 1e5 + 0.01, 2e5])
    smooth = smooth_minimum(distance, 50.0)
    assert 1e5 - np.log(3) / 50 <= smooth <= 1e5
    assert smooth_minimum(np.array([0.3]), 7.0) == pytest.approx(0.3)


def test_alpha_is_raised_until_half_the_clearance_is_left() -> None:
    distance = np.full(100, 1.02)
    alpha = SmoothMinimum(50.0).alpha(distance, 1.0)
    assert alpha > 50
    assert smooth_minimum(distance, alpha) - 1.0 >= 0.01 - 1e-12
    assert SmoothMinimum(50.0).alpha(np.array([9.0]), 1.0) == 50


def test_touching_is_infinite() -> None:
    for potential in (
        ContactBarriers(ONE, ONE, ONE),
        SmoothMinimumBarriers(ONE, ONE, ONE, 50 * ONE),
    ):
        assert summed(potential, [1.01]).value < np.inf
        assert summed(potential, [1.0]).value == np.inf
        assert summed(potential, [0.9, 1.5]).value == np.inf
        assert summed(potential, [0.9, 1.5]).least < 0


def test_what_is_out_of_reach_is_not_there_at_all() -> None:
    # Neither in the value nor in the least clearance: else both would depend on who happens to be listed.
    for potential in (
        ContactBarriers(ONE, ONE, 0.5 * ONE),
        SmoothMinimumBarriers(ONE, ONE, 0.5 * ONE, 50 * ONE),
    ):
        far = summed(potential, [1.5, 1.7])
        if isinstance(potential, SmoothMinimumBarriers):
            far = summed(potential, [1.6, 1.7])
        assert (far.value, far.least) == (0.0, np.inf)
        assert not far.slope.any()


def test_a_smooth_minimum_of_one_is_a_contact() -> None:
    one = summed(ContactBarriers(ONE, ONE, ONE), [1.3])
    smooth = summed(SmoothMinimumBarriers(ONE, ONE, ONE, 50 * ONE), [1.3])
    assert smooth.value == pytest.approx(one.value)
    assert smooth.slope == pytest.approx(one.slope)
    assert smooth.majorizer == pytest.approx(one.majorizer)
    assert smooth.curvature + smooth.coupling == pytest.approx(one.curvature)


def test_friends_are_drawn_to_where_they_touch() -> None:
    pull = QuadraticPull(ONE, 3.0 * ONE, 50.0)
    assert summed(pull, [1.0]).value == 0.0
    apart = summed(pull, [4.0])
    assert apart.value == pytest.approx(27.0)
    assert apart.slope == pytest.approx([18.0])
    assert summed(pull, []).value == 0.0


def test_sharpness_is_chosen_once_and_only_for_who_is_there() -> None:
    contacts = ContactList.grouped(np.zeros((100, 4), dtype=np.int64), np.full(100, 1))
    radius, kept = np.ones(3), np.array([np.nan, np.nan, 70.0])
    chosen = SmoothMinimum(50.0).sharpened(kept, contacts, np.full(100, 1.02), radius)
    assert np.isnan(chosen[0])
    assert chosen[1] > 50.0
    assert chosen[2] == 70.0
    again = SmoothMinimum(50.0).sharpened(chosen, contacts, np.full(100, 1.001), radius)
    assert np.array_equal(again, chosen, equal_nan=True)


def test_contacts_out_of_the_weighing_reach_weigh_nothing() -> None:
    alpha, reach = 5.0, 0.25
    many = 400
    # As near as a barrier can still be felt, with as many others as there may be just as near.
    nearest = reach + np.log(many) / alpha
    distances = np.append(np.full(many - 1, nearest), reach + weighing_reach(many, alpha))
    whole = smooth_minimum(distances, alpha)
    assert whole == pytest.approx(reach, abs=1e-3)
    assert smooth_minimum(distances[:-1], alpha) - whole <= 1e-15


def test_the_stepped_rule_stops_at_the_first_step_that_gives_a_logarithm() -> None:
    distance = np.full(100, 1.02)
    alpha = SmoothMinimum(50.0, rule="stepped").alpha(distance, 1.0)
    steps = round((alpha / 50.0 - 1.0) / 0.1)
    assert steps > 10
    assert alpha == pytest.approx(50.0 * (1.0 + 0.1 * steps))
    assert smooth_minimum(distance, alpha) > 1.0
    assert smooth_minimum(distance, 50.0 * (1.0 + 0.1 * (steps - 1))) <= 1.0
    assert SmoothMinimum(50.0, rule="stepped").alpha(np.full(100, 0.9), 1.0) == 50.0


def test_the_cutoff_takes_light_contacts_out_of_the_stand_in_alone() -> None:
    whole = summed(SmoothMinimumBarriers(ONE, ONE, ONE, 5 * ONE), [1.3, 1.5, 1.7])
    sparse = summed(SmoothMinimumBarriers(ONE, ONE, ONE, 5 * ONE, cutoff=0.2), [1.3, 1.5, 1.7])
    shares = np.exp(-5 * np.array([0.0, 0.2, 0.4]))
    assert (sparse.majorizer > 0).tolist() == (shares >= 0.2).tolist() == [True, True, False]
    assert np.array_equal(sparse.majorizer[:2], whole.majorizer[:2])
    assert sparse.value == whole.value
    assert np.array_equal(sparse.slope, whole.slope)
    assert np.array_equal(sparse.curvature, whole.curvature)
