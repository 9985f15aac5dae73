"""What the metric's c does to whole plans, as a CSV and as two Markdown tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.metric import MetricTrial
from stplan.bench.result_files import result_files

_TOTALS = (
    "time_scale",
    "planned",
    "over the best, median %",
    "mean %",
    "worst %",
    "iterations",
    "s",
)


def files(trials: Sequence[MetricTrial]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files("metric", csv_text(trials), markdown_text(trials))


def csv_text(trials: Sequence[MetricTrial]) -> str:
    """One row a scene and metric."""
    return csv_table(
        [
            {
                "scene": one.scene,
                "agents": one.agents,
                "time_scale": one.time_scale,
                "planned": one.found,
                "cost": one.cost,
                "iterations": one.iterations,
                "seconds": one.seconds,
            }
            for one in trials
        ]
    )


def markdown_text(trials: Sequence[MetricTrial]) -> str:
    """Sums over all scenes for every metric, then cost (seconds) of every scene."""
    scenes = list(dict.fromkeys(one.scene for one in trials))
    scales = list(dict.fromkeys(one.time_scale for one in trials))
    by = {(one.scene, one.time_scale): one for one in trials}
    least = {scene: _least([by[scene, scale].cost for scale in scales]) for scene in scenes}
    totals = [_total(str(scale), [by[scene, scale] for scene in scenes], least) for scale in scales]
    rows = [
        (
            scene,
            str(by[scene, scales[0]].agents),
            *(_cell(by[scene, scale]) for scale in scales),
        )
        for scene in scenes
    ]
    head = ("scene", "agents", *(f"{scale}: cost (s)" for scale in scales))
    return table(_TOTALS, totals) + "\n" + table(head, rows)


def _least(costs: Sequence[float]) -> float:
    """The least of `costs` that is known, nan where none is."""
    known = [cost for cost in costs if not np.isnan(cost)]
    return min(known, default=np.nan)


def _total(scale: str, trials: Sequence[MetricTrial], least: dict[str, float]) -> tuple[str, ...]:
    over = [100.0 * (one.cost / least[one.scene] - 1.0) for one in trials if one.found]
    return (
        scale,
        f"{sum(one.found for one in trials)} of {len(trials)}",
        *(number(float(of(over)) if over else np.nan, ".1f") for of in (np.median, np.mean, max)),
        str(sum(one.iterations for one in trials)),
        f"{sum(one.seconds for one in trials):.1f}",
    )


def _cell(one: MetricTrial) -> str:
    return f"{one.cost:.5g} ({one.seconds:.1f})" if one.found else f"none ({one.seconds:.1f})"
