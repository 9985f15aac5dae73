"""Numbers in sentences: no exponents, and different where they differ."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stplan.amounts import amount, distinct, place


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (-0.0, "0"), (0.6, "0.6"), (395300.0, "395300"), (395312.0, "395300"),
        (0.000123456, "0.0001235"), (1e9, "1000000000"), (-2.5e-7, "-0.00000025"),
    ],
)  # fmt: skip
def test_amounts_have_no_exponent(value: float, text: str) -> None:
    assert amount(value) == text


@pytest.mark.parametrize(
    ("point", "text"),
    [
        ((500000.25, 4600000.125), "(500000.25, 4600000.125)"),
        ((0.0, -0.0), "(0, 0)"),
        ((1 / 3, 1e-8), "(0.333333, 0.00000001)"),
    ],
)
def test_places_have_fixed_decimals(point: tuple[float, float], text: str) -> None:
    assert place(*point) == text


def test_numbers_that_differ_are_shown_so() -> None:
    assert distinct(0.6, 0.6 + 1e-9) == ("0.6", "0.600000001")
    assert distinct(0.5999, 0.6) == ("0.5999", "0.6")
    assert distinct(0.6, 0.6) == ("0.6", "0.6")
    assert distinct(1.0, 1.0 + 2**-52, 3.0) == ("1", "1.0000000000000002", "3")


@given(st.lists(st.floats(-1e9, 1e9), min_size=2, max_size=4))
def test_any_numbers_that_differ_are_shown_so(values: list[float]) -> None:
    texts = distinct(*values)
    assert len(set(texts)) == len(set(values))
    assert not any("e" in text for text in texts)
