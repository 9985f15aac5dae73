"""Kinetic cost of single curves, in J s."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.problem.kinetic_cost import kinetic_cost, least_kinetic_cost


def test_a_constant_speed_costs_half_the_mass_times_its_square_times_the_time():
    curve = np.array([[0.0, 0.0, 1.0], [3.0, 4.0, 3.0], [6.0, 8.0, 5.0]])
    assert kinetic_cost(80.0, curve) == pytest.approx(0.5 * 80.0 * 2.5**2 * 4.0)
    assert least_kinetic_cost(80.0, curve[:, :2], 4.0) == pytest.approx(kinetic_cost(80.0, curve))


def test_nothing_is_cheaper_than_straight_at_constant_speed():
    rng = np.random.default_rng(3)
    for _ in range(20):
        curve = np.column_stack([rng.normal(size=(6, 2)), np.cumsum(rng.uniform(0.1, 1.0, 6))])
        least = least_kinetic_cost(2.0, curve[[0, -1], :2], float(np.ptp(curve[:, 2])))
        assert kinetic_cost(2.0, curve) > least


def test_standing_costs_nothing():
    assert kinetic_cost(1.0, np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 9.0]])) == 0.0
