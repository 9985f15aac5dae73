"""Measurements of the seeder as a CSV of draws and as a Markdown table of families."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import table
from stplan.bench.result_files import result_files
from stplan.bench.seeding import Measurement, growth_exponent

_HEAD = (
    "family",
    "draws",
    "success %",
    "median s",
    "worst s",
    "median cpu s",
    "kinetic over straight, median",
    "found by",
)


def files(measurements: Sequence[Measurement]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files("seeding", csv_text(measurements), markdown_text(measurements))


def csv_text(measurements: Sequence[Measurement]) -> str:
    """One row a draw."""
    return csv_table([asdict(one) for one in measurements])


def markdown_text(measurements: Sequence[Measurement]) -> str:
    """One row a family, padded to be read as it stands, and the growth with agents."""
    text = table(_HEAD, _rows(measurements), {0, len(_HEAD) - 1})
    exponent = growth_exponent(measurements)
    if exponent is not None:
        text += f"\nTime on the open field grows with agents^{exponent:.2f} (fitted).\n"
    return text


def _rows(measurements: Sequence[Measurement]) -> list[tuple[str, ...]]:
    """Cells of every family; failed draws count in the times, as long as they took."""
    rows: list[tuple[str, ...]] = []
    for name in dict.fromkeys(one.family for one in measurements):
        ones = [one for one in measurements if one.family == name]
        good = [one for one in ones if one.success]
        finders = Counter(one.found_by for one in good)
        rows.append(
            (
                name,
                str(len(ones)),
                f"{100.0 * len(good) / len(ones):.0f}",
                f"{np.median([one.seconds for one in ones]):.3f}",
                f"{max(one.seconds for one in ones):.3f}",
                f"{np.median([one.cpu_seconds for one in ones]):.3f}",
                f"{np.median([one.kinetic_over_straight for one in good]):.3f}" if good else "-",
                ", ".join(f"{finder} {count}" for finder, count in finders.most_common()) or "-",
            )
        )
    return rows
