"""The figures the planner is held to, as a CSV and as Markdown tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.figures import Case, Figure, Quantity
from stplan.bench.markdown import number, table
from stplan.bench.result_files import result_files

_HEAD = (
    "figure",
    "agents",
    "conflicts",
    "seed s",
    "optimise s",
    "whole s",
    "iterations",
    "ms each",
    "evaluation %",
    "kinetic over straight",
    "clearance m",
    "certified",
    "MiB",
)
_ASKED_HEAD = ("figure", "quantity", "asked", "measured", "reached")
_FORMATS: dict[Quantity, str] = {
    "total seconds": ".2f",
    "kinetic over straight": ".4f",
    "evaluation share": ".3f",
    "peak memory, MiB": ".0f",
    "over converged cost": ".3f",
}


def files(chosen: Sequence[Case], figures: Sequence[Figure]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files("figures", csv_text(figures), markdown_text(chosen, figures))


def csv_text(figures: Sequence[Figure]) -> str:
    """One row a case."""
    rows = [
        {"figure": one.name, "conflicts": one.conflicts}
        | asdict(one.run)
        | {"over_converged": one.over_converged, "converged_seconds": one.converged_seconds}
        for one in figures
    ]
    return csv_table(rows)


def markdown_text(chosen: Sequence[Case], figures: Sequence[Figure]) -> str:
    """What was measured of every case, then every figure asked for beside the measured one."""
    return f"{measured_table(figures)}\n{asked_table(chosen, figures)}"


def measured_table(figures: Sequence[Figure]) -> str:
    """One row a case."""
    return table(_HEAD, [_cells(one) for one in figures])


def _cells(figure: Figure) -> tuple[str, ...]:
    one = figure.run
    return (
        figure.title,
        str(one.agents),
        "-" if figure.conflicts is None else str(figure.conflicts),
        number(one.seed_seconds, ".2f"),
        number(one.optimise_seconds, ".2f"),
        number(one.total_seconds, ".2f"),
        str(one.iterations),
        number(1e3 * one.iteration_seconds, ".1f"),
        number(100 * one.evaluation_share, ".0f"),
        f"{number(one.kinetic_seed, '.4f')} -> {number(one.kinetic_end, '.4f')}",
        number(one.clearance, ".2g"),
        "yes" if one.certified else "no",
        number(one.peak_mib, ".0f"),
    )


def asked_table(chosen: Sequence[Case], figures: Sequence[Figure]) -> str:
    """One row a figure asked for; one that is missed says by how much."""
    rows = []
    for case, figure in zip(chosen, figures, strict=True):
        certified = "yes" if figure.run.certified else "no"
        rows.append((case.title, "certified", "yes", certified, certified))
        for quantity, most in case.asked:
            digits, value = _FORMATS[quantity], figure.value(quantity)
            cells = format(most, digits), number(value, digits), _verdict(value, most, digits)
            rows.append((case.title, quantity, *cells))
    return table(_ASKED_HEAD, rows, {0, 1, 4})


def _verdict(value: float, most: float, digits: str) -> str:
    if np.isnan(value):
        return "no"
    return "yes" if value <= most else f"no, {value - most:{digits}} too much"
