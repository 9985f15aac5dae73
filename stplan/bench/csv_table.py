"""Measurements as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence


def csv_table(rows: Sequence[Mapping[str, object]]) -> str:
    """One line a row under the keys of the first; numbers that are missing (None, nan) are empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    if rows:
        writer.writerow(rows[0])
    for row in rows:
        writer.writerow(_plain(value) for value in row.values())
    return stream.getvalue()


def _plain(value: object) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)
