"""A sweep as a CSV of points, a Markdown table of sizes and exponents, and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.plots import Series, growth_figure
from stplan.bench.result_files import result_files
from stplan.bench.scaling import PARTS, Point, Sweep, exponent, medians

_TIMES = PARTS[:3]


def files(sweep: Sweep, points: Sequence[Point]) -> dict[str, bytes]:
    """Names and contents of the files of a sweep."""
    return result_files(
        sweep.name, csv_text(points), markdown_text(sweep, points), picture(sweep, points)
    )


def csv_text(points: Sequence[Point]) -> str:
    """One row a draw."""
    return csv_table(
        [
            {"size": one.size, "measured_size": one.measured, "draw": one.draw}
            | {f"{part.replace(' ', '_').lower()}_ms": one.part(part) for part in _TIMES}
            | asdict(one.run)
            for one in points
        ]
    )


def markdown_text(sweep: Sweep, points: Sequence[Point]) -> str:
    """One row a size, medians over the draws, and the fitted exponents below."""
    head = (sweep.size, *(f"{part}, ms" for part in _TIMES), PARTS[3], "iterations", "planned")
    rows = []
    for size in dict.fromkeys(one.size for one in points):
        draws = [one for one in points if one.size == size]
        planned = [one for one in draws if one.run.certified]
        sizes, _ = medians(draws, PARTS[0])
        values = [medians(draws, part)[1] for part in PARTS]
        rows.append(
            (
                f"{sizes[0]:.0f}" if sizes else str(size),
                *(number(value[0], ".2f") if value else "-" for value in values[:3]),
                f"{values[3][0]:.0f}" if values[3] else "-",
                f"{sum(one.run.iterations for one in draws) / len(draws):.0f}",
                f"{len(planned)} of {len(draws)}",
            )
        )
    powers = [exponent(points, part) for part in PARTS]
    rows.append(("exponent", *(number(power, ".2f") for power in powers), "", ""))
    asked = f"Time an iteration ~ size^{powers[0]:.2f} (fitted); at most {sweep.asked:g} is asked."
    return f"{sweep.title}\n\n{table(head, rows)}\n{asked}\n"


def picture(sweep: Sweep, points: Sequence[Point]) -> bytes:
    """PNG of the times over the sizes."""
    series = [Series(part, *medians(points, part), exponent(points, part)) for part in _TIMES]
    return growth_figure(sweep.title, sweep.size, "time of an iteration, ms", series)
