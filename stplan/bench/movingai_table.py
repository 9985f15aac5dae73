"""Measurements on grid maps as a CSV and as a Markdown table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.movingai import GridOutcome
from stplan.bench.result_files import result_files

_HEAD = ("map", "agents", "radius", "plan", "s", "above best %", "kinetic", "LaCAM", "its s")


def files(outcomes: Sequence[GridOutcome]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    rows = [
        (
            one.map, str(one.agents), f"{one.share:g}", "certified" if one.planned else one.status,
            f"{one.seconds:.1f}", number(100 * one.excess, ".1f"), number(one.kinetic, ".3f"),
            one.rival or "-", number(one.rival_seconds, ".1f"),
        )
        for one in outcomes
    ]  # fmt: skip
    text = table(_HEAD, rows, {0, 3, 7})
    return result_files("movingai", csv_table([asdict(one) for one in outcomes]), text)
