"""The assembled program: derivatives of the sum, its domain, and Ipopt's own derivative check."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.costs.formulation import Penalties
from stplan.costs.registry import registered_terms
from stplan.nlp.ipopt.adapter import Ipopt
from stplan.nlp.program import NonlinearProgram, _merge_entries
from stplan.nlp.step_control import StepControl
from tests.derivatives.checker import (
    Differentiable,
    check_differences,
    check_not_vacuous,
    check_structure_is_fixed,
    check_taylor_slopes,
    dense,
)
from tests.derivatives.samples import LAYOUT, OFFSETS, sample_knots
from tests.nlp.sample_programs import sample_program

PENALTIES = Penalties(limit=1.3, timing=0.7, inset=0.3)


class _AsFunction:
    """A program's objective, with its Hessian's structure as terms give theirs."""

    def __init__(self, program: NonlinearProgram) -> None:
        self.value = program.value
        self.gradient = program.gradient
        self.hessian = program.hessian
        self.hessian_structure = lambda: program.hessian_structure


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("model", ["contacts", "smooth-minimum"])
def test_derivatives_of_the_assembled_lagrangian(model: str, limited: bool) -> None:
    # The constraints are linear: they add nothing to the Lagrangian's Hessian.
    function: Differentiable = _AsFunction(
        sample_program(limited, clearance_model=model, hessian="exact")
    )
    knots = sample_knots()
    check_differences(function, knots)
    check_not_vacuous(function, knots)
    check_taylor_slopes(function, knots)
    other = knots + 0.01 * np.random.default_rng(7).normal(size=knots.shape)
    check_structure_is_fixed(function.hessian_structure, function.hessian, knots, other)


def test_every_registered_term_is_in_some_program() -> None:
    planning, restoring = sample_program(True), sample_program(True, PENALTIES)
    names = {term.name for term in (*planning.terms, *restoring.terms)}
    assert names == {kind.name for kind in registered_terms()}


def test_restoration_leaves_preferences_out_and_prices_times() -> None:
    restoring = sample_program(True, PENALTIES, hessian="exact")
    names = {term.name for term in restoring.terms}
    assert "acceleration" not in names
    assert {"timing", "arrival", "speed limit", "meeting", "collision", "wall", "kinetic"} <= names
    assert not restoring.exact


def test_the_gauss_newton_hessian_is_the_terms_own_summed() -> None:
    program, knots = sample_program(True), sample_knots()
    expected = sum(
        dense(term.gauss_newton_structure(), term.gauss_newton_hessian(knots), knots.size)
        for term in program.terms
    )
    found = dense(program.hessian_structure, program.hessian(knots), knots.size)
    assert found == pytest.approx(expected)
    exact = sample_program(True, hessian="exact")
    assert len(exact.hessian_structure[0]) > len(program.hessian_structure[0])


@pytest.mark.parametrize("size", [1, 7, 40])
def test_entries_of_all_terms_are_merged_row_by_row(size: int) -> None:
    rng = np.random.default_rng(size)
    rows, columns = rng.integers(0, size, (2, 200))
    merged_rows, merged_columns, places = _merge_entries(rows, columns, size)
    codes, expected = np.unique(rows * size + columns, return_inverse=True)
    assert np.array_equal(merged_rows * size + merged_columns, codes)
    assert np.array_equal(places, expected)
    nothing = np.empty(0, dtype=np.int64)
    assert [len(part) for part in _merge_entries(nothing, nothing, size)] == [0, 0, 0]


def test_linear_constraints() -> None:
    program = sample_program(limited=True)
    linear = program.linear
    # Agent 0 has guarded segments; the 5 and 6 of agents 1 and 2 are limited in their share.
    segments = LAYOUT.num_segments[0]
    jacobian = np.zeros((segments + 1 + 11, program.num_variables))
    jacobian[linear.rows, linear.columns] = linear.values
    assert len(set(zip(linear.rows.tolist(), linear.columns.tolist(), strict=True))) == len(
        linear.rows
    )
    x = sample_knots().ravel()
    found = linear.at(x)
    assert jacobian @ x == pytest.approx(found)
    ((i, j),) = program.constraints.links
    assert found[segments] == pytest.approx(x[3 * j + 2] - x[3 * i + 2])
    own = sample_knots()[OFFSETS[1] : OFFSETS[2], 2]
    shares = program.constraints.greatest_share[5:10]
    assert found[segments + 1 : segments + 6] == pytest.approx(shares * np.ptp(own) - np.diff(own))
    assert (linear.least[segments], linear.greatest[segments]) == (0.0, 0.0)
    assert (linear.least[:segments] > 0).all()
    assert (found[segments + 1 :] > 0).all()
    assert len(sample_program().linear.least) == segments


def test_touching_and_time_running_back_are_undefined() -> None:
    program = sample_program()
    knots = sample_knots()
    assert np.isfinite(program.value(knots))
    back = knots.copy()
    back[2, 2] = back[3, 2]
    assert program.value(back) == np.inf
    through = knots.copy()
    through[8] = knots[2]
    assert program.value(through) == np.inf
    outside = knots.copy()
    outside[2, 1] = -5.0
    assert program.value(outside) == np.inf
    broken = knots.copy()
    broken[2, 1] = np.nan
    assert program.value(broken) == np.inf
    assert np.isfinite(program.value(knots)), "what was asked before does not matter"


@pytest.mark.parametrize("model", ["contacts", "smooth-minimum"])
def test_ipopt_derivative_test_passes(model: str, capfd: pytest.CaptureFixture[str]) -> None:
    options = {
        "derivative_test": "second-order",
        "derivative_test_perturbation": 1e-7,
        "derivative_test_tol": 1e-4,
        "point_perturbation_radius": 0.0,
        "print_level": 5,
    }
    program = sample_program(clearance_model=model, hessian="exact")
    Ipopt("mumps", options=options).solve(
        StepControl(program, sample_knots()), sample_knots(), max_iterations=1,
        objective_scale=1.0, stop=lambda _: True,
    )  # fmt: skip
    assert "No errors detected by derivative checker." in capfd.readouterr().out
