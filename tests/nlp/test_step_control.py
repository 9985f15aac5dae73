"""Which steps are refused, and when the Hessian is damped."""

from __future__ import annotations

import numpy as np

from stplan.nlp.step_control import KEPT_SHARE
from tests.derivatives.samples import sample_knots
from tests.nlp.sample_programs import sample_control


def test_no_step_goes_past_a_limit() -> None:
    control = sample_control(limited=True)
    knots = sample_knots()
    assert np.isfinite(control.value(knots.ravel()))
    hurried = knots.copy()
    hurried[2, 2] = hurried[3, 2] - 0.1
    assert control.value(hurried.ravel()) == np.inf


def test_no_step_uses_up_nearly_all_clearance() -> None:
    control, knots = sample_control(), sample_knots()
    least = control.least_clearance(knots)
    # The first agent drifts sideways towards the second, bit by bit.
    short = 0
    for share in np.linspace(0.0, 1.0, 101):
        nearer = knots.copy()
        nearer[:6, 1] += share * least
        value, left = control.program.value(nearer), control.least_clearance(nearer)
        refused = np.isfinite(value) and left < KEPT_SHARE * least
        assert control.value(nearer.ravel()) == (np.inf if refused else value)
        short += refused
    assert 0 < short < 50


def test_steps_that_contacts_cut_short_are_damped_and_long_ones_less_and_less() -> None:
    control = sample_control()
    x = sample_knots().ravel()
    control.accept(x, 0.01)
    assert control.damping == 0.0, "nothing has touched anything yet"
    plain = control.hessian(x)
    # All agents in one place: the collision cost is undefined there.
    crowded = x.reshape(-1, 3).copy()
    crowded[:, :2] = crowded[0, :2]
    assert control.value(crowded.ravel()) == np.inf
    control.accept(x, 0.01)
    assert control.damping > 0.0
    rows, columns = control.program.hessian_structure
    added = control.hessian(x) - plain
    assert (added[rows == columns] > 0).all()
    assert not added[rows != columns].any()
    before = control.damping
    control.accept(x, 1.0)
    assert control.damping < before
    for _ in range(9):
        control.accept(x, 1.0)
    assert control.damping == 0.0


def test_the_program_knows_nothing_of_steps() -> None:
    control, knots = sample_control(), sample_knots()
    x = knots.ravel()
    value, gradient = control.program.value(knots), control.program.gradient(knots)
    crowded = knots.copy()
    crowded[:, :2] = crowded[0, :2]
    control.value(crowded.ravel())
    control.accept(x, 0.01)
    assert control.damping > 0
    assert control.program.value(knots) == value == control.value(x)
    assert np.array_equal(control.program.gradient(knots), gradient)
    assert np.array_equal(control.gradient(x), gradient.ravel())
