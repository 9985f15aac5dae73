"""Every cost room's derivatives, none left out."""

from __future__ import annotations

import importlib
import pkgutil

import numpy as np
import pytest

import stplan.costs
from stplan.costs.limit import Limit
from stplan.costs.term import Term
from tests.derivatives.checker import (
    check_differences,
    check_not_vacuous,
    check_structure_is_fixed,
    check_taylor_slopes,
    dense,
)
from tests.derivatives.samples import sample_knots, sample_terms

LABELS = sorted(sample_terms())


def concrete_rooms(base: type[Term] = Term) -> set[str]:
    """Names of all rooms in the package, found by import."""
    for module in pkgutil.iter_modules(stplan.costs.__path__):
        importlib.import_module(f"stplan.costs.{module.name}")
    names = set()
    for room in base.__subclasses__():
        names |= concrete_rooms(room)
        if not getattr(room, "__abstractmethods__", None):
            names.add(room.name)
    return names


def test_no_room_is_left_out() -> None:
    assert {term.name for term in sample_terms().values()} == concrete_rooms()


@pytest.mark.parametrize("label", LABELS)
def test_differences(label: str) -> None:
    check_differences(sample_terms()[label], sample_knots())


@pytest.mark.parametrize("label", LABELS)
def test_taylor_slopes(label: str) -> None:
    rng = np.random.default_rng(5)
    direction = 0.02 * rng.normal(size=sample_knots().shape)
    check_taylor_slopes(sample_terms()[label], sample_knots(), direction)


@pytest.mark.parametrize("label", LABELS)
def test_nothing_is_vacuous(label: str) -> None:
    check_not_vacuous(sample_terms()[label], sample_knots())


@pytest.mark.parametrize("label", LABELS)
def test_structure_does_not_depend_on_values(label: str) -> None:
    rng = np.random.default_rng(6)
    other = sample_knots() + 0.01 * rng.normal(size=sample_knots().shape)
    check_structure_is_fixed(sample_terms()[label], sample_knots(), other)


@pytest.mark.parametrize("label", LABELS)
def test_gauss_newton_stand_in_is_positive_semidefinite_where_promised(label: str) -> None:
    term, knots = sample_terms()[label], sample_knots()
    stand_in = dense(term.hessian_structure(), term.gauss_newton_hessian(knots), knots.size)
    assert np.isfinite(stand_in).all()
    if isinstance(term, Limit) or term.name in ("collision", "grouping", "wall", "regularity"):
        eigenvalues = np.linalg.eigvalsh(stand_in)
        assert eigenvalues[0] >= -1e-9 * eigenvalues[-1]
        assert eigenvalues[-1] > 0


@pytest.mark.parametrize("label", [label for label in LABELS if " limit, " in label])
def test_samples_of_limits_lie_on_both_sides_of_the_switch(label: str) -> None:
    term, knots = sample_terms()[label], sample_knots()
    assert isinstance(term, Limit)
    shares = term.shares(knots)
    assert 0.1 < shares.max() < 1.0
    if "Penalty" in label:
        assert (shares > 0.4).any()
        assert (shares < 0.4).any()


class _Broken:
    """A term whose derivatives are wrong on purpose."""

    def __init__(self, term: Term, fault: str) -> None:
        self._term = term
        self._fault = fault
        self.value = term.value
        self.hessian_structure = term.hessian_structure

    def gradient(self, knots):
        right = self._term.gradient(knots)
        return {"sign": -right, "weight": 1.01 * right}.get(self._fault, right)

    def hessian(self, knots):
        right = self._term.hessian(knots)
        if self._fault == "missing entry":
            right = right.copy()
            right[np.abs(right).argmax()] = 0.0
        return 1.01 * right if self._fault == "curvature" else right


@pytest.mark.parametrize("fault", ["sign", "weight", "missing entry", "curvature"])
@pytest.mark.parametrize("label", LABELS)
def test_the_checker_rejects_wrong_derivatives(label: str, fault: str) -> None:
    broken = _Broken(sample_terms()[label], fault)
    with pytest.raises(AssertionError):
        check_differences(broken, sample_knots())
