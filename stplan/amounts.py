"""Numbers: how large they may be, and how sentences show them: in fixed decimals, apart where they differ."""

from __future__ import annotations

from decimal import Decimal

# Metres, seconds, kilograms beyond this are a mistake of units; squares of them stay exact enough.
LARGEST = 1e9
# Digits that a number shows at least, and that tell any two of them apart.
FEWEST_DIGITS, MOST_DIGITS = 4, 17
# Decimals of coordinates: micrometres.
PLACE_DECIMALS = 6


def amount(value: float, digits: int = FEWEST_DIGITS) -> str:
    """`value` to so many significant digits, never with an exponent: 395300, 0.00012."""
    text = f"{Decimal(f'{value + 0.0:.{digits}g}'):f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def distinct(*values: float, digits: int = FEWEST_DIGITS) -> tuple[str, ...]:
    """`values` to as few significant digits as show which of them differ, `digits` at least."""
    for count in range(digits, MOST_DIGITS):
        texts = tuple(amount(value, count) for value in values)
        if len(set(texts)) == len(set(values)):
            return texts
    return tuple(amount(value, MOST_DIGITS) for value in values)


def place(x: float, y: float) -> str:
    """A point in the plane (m): ``(395300.25, -0.5)``."""
    return f"({_coordinate(x)}, {_coordinate(y)})"


def _coordinate(value: float) -> str:
    text = f"{value + 0.0:.{PLACE_DECIMALS}f}".rstrip("0").rstrip(".")
    # What is that small would read as the origin.
    return amount(value) if float(text) == 0 != value else text
