"""Markdown tables that can be read as they stand."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]], words: Collection[int] = (0,)) -> str:
    """Rows of cells under `head`, padded; columns in `words` to the left, figures to the right."""
    widths = [max(len(row[column]) for row in (head, *rows)) for column in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        padded = [
            cell.ljust(width) if column in words else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        return f"| {' | '.join(padded)} |"

    rule = [
        "-" * width if column in words else "-" * (width - 1) + ":"
        for column, width in enumerate(widths)
    ]
    return "\n".join([line(head), f"| {' | '.join(rule)} |", *(line(row) for row in rows)]) + "\n"


def number(value: float, digits: str) -> str:
    """`value` in the format `digits`, a dash where there is none (nan)."""
    return "-" if math.isnan(value) else format(value, digits)
