"""The derivatives of every registered term, none left out."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.contacts.contact_term import ContactTerm
from stplan.costs.limit import MotionLimit
from stplan.costs.registry import registered_terms
from stplan.nlp.term import Capability, Term
from tests.derivatives.checker import (
    check_differences,
    check_not_vacuous,
    check_structure_is_fixed,
    check_taylor_slopes,
    dense,
)
from tests.derivatives.samples import sample_knots, samples

SAMPLES = samples()
# A term without a sample stands here too, and fails.
CASES = [
    pytest.param(kind.name, variant, id=f"{kind.name} {variant}")
    for kind in registered_terms()
    for variant in SAMPLES.get(kind.name, {"no sample": None})
]
each = pytest.mark.parametrize(("name", "variant"), CASES)


def sample(name: str, variant: str) -> Term:
    assert name in SAMPLES, f"{name} has no sample in tests/derivatives/samples.py"
    term = SAMPLES[name][variant]()
    assert term.name == name
    return term


def test_every_sample_is_of_a_registered_term() -> None:
    assert set(SAMPLES) == {kind.name for kind in registered_terms()}


@each
def test_differences(name: str, variant: str) -> None:
    check_differences(sample(name, variant), sample_knots())


@each
def test_taylor_slopes(name: str, variant: str) -> None:
    check_taylor_slopes(sample(name, variant), sample_knots())


@each
def test_nothing_is_vacuous(name: str, variant: str) -> None:
    check_not_vacuous(sample(name, variant), sample_knots())


@each
def test_structures_do_not_depend_on_values(name: str, variant: str) -> None:
    term, knots = sample(name, variant), sample_knots()
    rng = np.random.default_rng(6)
    other = knots + 0.01 * rng.normal(size=knots.shape)
    check_structure_is_fixed(term.hessian_structure, term.hessian, knots, other)
    check_structure_is_fixed(term.gauss_newton_structure, term.gauss_newton_hessian, knots, other)


@each
def test_the_gauss_newton_hessian_is_convex_or_the_exact_one(name: str, variant: str) -> None:
    term, knots = sample(name, variant), sample_knots()
    stand_in = dense(term.gauss_newton_structure(), term.gauss_newton_hessian(knots), knots.size)
    eigenvalues = np.linalg.eigvalsh(stand_in)
    assert eigenvalues[-1] > 0
    if eigenvalues[0] < -1e-9 * eigenvalues[-1]:
        exact = dense(term.hessian_structure(), term.hessian(knots), knots.size)
        assert np.array_equal(stand_in, exact)


@pytest.mark.parametrize(
    ("name", "variant"), [case for case in CASES if "LimitBarrier" in str(case.values[1])]
)
def test_limits_are_replaced_by_their_convex_part(name: str, variant: str) -> None:
    term, knots = sample(name, variant), sample_knots()
    exact = dense(term.hessian_structure(), term.hessian(knots), knots.size)
    convex = dense(term.gauss_newton_structure(), term.gauss_newton_hessian(knots), knots.size)
    greatest = np.linalg.eigvalsh(convex)[-1]
    # Distances of those who meet bend the other way.
    assert name == "meeting" or np.linalg.eigvalsh(exact)[0] < -1e-3 * greatest
    assert np.linalg.eigvalsh(convex)[0] > -1e-12 * greatest
    assert np.linalg.eigvalsh(convex - exact)[0] > -1e-12 * greatest


@each
def test_samples_lie_on_both_sides_of_every_switch(name: str, variant: str) -> None:
    term, knots = sample(name, variant), sample_knots()
    if isinstance(term, MotionLimit):
        shares = term.shares(knots)
        assert 0.1 < shares.max() < 1.0
        if "Penalty" in variant:
            assert (shares > 0.4).any()
            assert (shares < 0.4).any()
    if Capability.CLEARANCE in term.capabilities and "range inf" not in variant:
        assert isinstance(term, ContactTerm)
        curvature = term.measured(knots)[1].majorizer
        assert (curvature > 0).any()
        assert (curvature == 0).any()
    if name == "timing":
        missing = term.missing(knots)  # type: ignore[attr-defined]
        assert (missing > 0).any()
        assert (missing < 0).any()
        assert (missing == 0).any()


class _Broken:
    """A term whose derivatives are wrong on purpose."""

    def __init__(self, term: Term, fault: str) -> None:
        self._term = term
        self._fault = fault
        self.value = term.value
        self.hessian_structure = term.hessian_structure

    def gradient(self, knots: FloatArray) -> FloatArray:
        right = self._term.gradient(knots)
        return {"sign": -right, "weight": 1.01 * right}.get(self._fault, right)

    def hessian(self, knots: FloatArray) -> FloatArray:
        right = self._term.hessian(knots)
        if self._fault == "missing entry":
            right = right.copy()
            right[np.abs(right).argmax()] = 0.0
        return {"curvature": 1.01 * right, "bent sign": -right}.get(self._fault, right)


FAULTS = ["sign", "weight", "missing entry", "curvature", "bent sign"]


@pytest.mark.parametrize("fault", FAULTS)
@each
def test_differences_reject_wrong_derivatives(name: str, variant: str, fault: str) -> None:
    with pytest.raises(AssertionError, match=r"gradient|hessian|structure"):
        check_differences(_Broken(sample(name, variant), fault), sample_knots())


@pytest.mark.parametrize("fault", FAULTS)
@each
def test_slopes_reject_wrong_derivatives(name: str, variant: str, fault: str) -> None:
    with pytest.raises(AssertionError, match="slopes"):
        check_taylor_slopes(_Broken(sample(name, variant), fault), sample_knots())
