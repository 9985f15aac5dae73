"""Plans of many agents as a CSV, as Markdown tables, and as figures of time and memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.plots import Series, growth_figure
from stplan.bench.result_files import result_files
from stplan.bench.scale import FIELD, Cluster, Scaled
from stplan.bench.scaling import growth

_HEAD = (
    "scene", "agents", "plan", "one process, s", "all cores, s", "asked s", "times faster",
    "processor time, s", "kinetic over straight", "peak MiB",
)  # fmt: skip
_CLUSTER = ("agents", "workers", "one process, s", "parts, s", "curves on their way, s", "all, s")


def files(measured: Sequence[Scaled], foretold: Sequence[Cluster]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    fields = [one for one in measured if one.family == FIELD and one.certified and one.workers == 1]
    found = result_files("scale", csv_text(measured), markdown_text(measured, foretold))
    if len(fields) > 1:
        sizes = [float(one.agents) for one in fields]
        for name, value, values in (
            ("time", "processor time, s", [one.processor_seconds for one in fields]),
            ("memory", "peak memory, MiB", [one.peak_mib for one in fields]),
        ):
            series = [Series(FIELD, sizes, values, growth(sizes, values))]
            found[f"scale-{name}.png"] = growth_figure(
                f"A whole plan: {name}", "agents", value, series
            )
    return found


def csv_text(measured: Sequence[Scaled]) -> str:
    """One row a plan."""
    return csv_table([asdict(one) for one in measured])


def markdown_text(measured: Sequence[Scaled], foretold: Sequence[Cluster]) -> str:
    """One row a scene, how fields grow, and what clusters would take."""
    scenes: dict[tuple[str, int], list[Scaled]] = {}
    for one in measured:
        scenes.setdefault((one.family, one.agents), []).append(one)
    text = table(_HEAD, [_row(plans) for plans in scenes.values()], (0, 2))
    fields = [one for one in measured if one.family == FIELD and one.certified and one.workers == 1]
    if len(fields) > 1:
        sizes = [float(one.agents) for one in fields]
        power = growth(sizes, [one.processor_seconds for one in fields])
        text += f"\nProcessor time of the open field ~ agents^{power:.2f} (fitted)."
        text += " An exponent of at most 1.15 is asked.\n"
    if foretold:
        rows = [
            (
                str(one.agents),
                str(one.workers),
                *(f"{value:.0f}" for value in (one.alone, one.parts, one.transfer, one.seconds)),
            )
            for one in foretold
        ]
        text += f"\nForetold for clusters:\n\n{table(_CLUSTER, rows, ())}"
    return text


def _row(plans: Sequence[Scaled]) -> tuple[str, ...]:
    first, last = plans[0], plans[-1]
    several = last.workers > first.workers
    return (
        first.family,
        str(first.agents),
        "certified" if all(one.certified for one in plans) else last.status,
        number(first.seconds, ".1f"),
        number(last.seconds if several else np.nan, ".1f"),
        "-" if first.asked is None else f"{first.asked:g}",
        number(first.seconds / last.seconds if several else np.nan, ".2f"),
        number(first.processor_seconds, ".1f"),
        number(first.kinetic, ".4f"),
        number(max(one.peak_mib for one in plans), ".0f"),
    )
