"""Crowds planned whole, as a CSV of all draws and as a Markdown table of all cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.crowds import CrowdSolve
from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.result_files import result_files

_HEAD = (
    "crowd", "agents", "certified", "median s", "longest s", "asked s", "length over least", "found by",
)  # fmt: skip


def files(measured: Sequence[CrowdSolve]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files("crowds", csv_text(measured), markdown_text(measured))


def csv_text(measured: Sequence[CrowdSolve]) -> str:
    """One row a draw."""
    return csv_table([asdict(one) for one in measured])


def markdown_text(measured: Sequence[CrowdSolve]) -> str:
    """One row a case."""
    cases: dict[tuple[str, float], list[CrowdSolve]] = {}
    for one in measured:
        # Streams of one rate differ in how many come.
        cases.setdefault((one.family, one.asked), []).append(one)
    return table(_HEAD, [_row(draws) for draws in cases.values()], (0, 7))


def _row(draws: Sequence[CrowdSolve]) -> tuple[str, ...]:
    seconds = [one.seconds for one in draws]
    return (
        draws[0].family,
        f"{np.median([one.agents for one in draws]):.0f}",
        f"{sum(one.certified for one in draws)} of {len(draws)}",
        f"{np.median(seconds):.1f}",
        f"{max(seconds):.1f}",
        f"{draws[0].asked:g}",
        number(float(max(one.length_over_least for one in draws)), ".4f"),
        "; ".join(sorted({one.found_by or "none" for one in draws})),
    )
