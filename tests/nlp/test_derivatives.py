"""The public check of derivatives accepts right ones and names what is wrong with others."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.errors import DerivativeError
from stplan.nlp.derivatives import check_derivatives
from stplan.nlp.term import Structure

KNOTS = np.random.default_rng(1).normal(size=(3, 3))


class Cubes:
    """The sum of cubes, with faults on demand."""

    def __init__(self, slope: float = 3.0, bend: float = 6.0, shift: int = 0) -> None:
        self._slope, self._bend, self._shift = slope, bend, shift

    def value(self, knots: FloatArray) -> float:
        return float((knots**3).sum())

    def gradient(self, knots: FloatArray) -> FloatArray:
        return self._slope * knots**2

    def hessian_structure(self) -> Structure:
        rows = np.arange(9)
        return rows, np.clip(rows - self._shift, 0, 8)

    def hessian(self, knots: FloatArray) -> FloatArray:
        return self._bend * knots.ravel()


def test_right_ones_pass() -> None:
    check_derivatives(Cubes(), KNOTS)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (Cubes(slope=3.03), "gradient is not the difference"),
        (Cubes(bend=6.06), "Hessian is not the difference"),
        (Cubes(shift=1), "outside the structure"),
        (Cubes(shift=-1), "above the diagonal"),
    ],
)
def test_wrong_ones_are_named(wrong: Cubes, said: str) -> None:
    with pytest.raises(DerivativeError, match=said):
        check_derivatives(wrong, KNOTS)


def test_a_point_that_proves_nothing_is_refused() -> None:
    with pytest.raises(DerivativeError, match="the gradient is zero here"):
        check_derivatives(Cubes(), np.zeros((3, 3)))
