"""What the convergence measurement writes: a CSV of runs, a table of variants, profiles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.bench.convergence import NEAR, Convergence
from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.plots import profile_figure
from stplan.bench.result_files import result_files

_HEAD = (
    "variant",
    "scenes",
    "failures",
    "to 1 %: reached",
    "iterations",
    "s",
    "to 0.1 %: reached",
    "iterations",
    "s",
    "over best, median %",
    "least clearance, mm",
)


def files(outcomes: Sequence[Convergence]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    return result_files(
        "convergence", csv_text(outcomes), markdown_text(outcomes), picture(outcomes)
    )


def csv_text(outcomes: Sequence[Convergence]) -> str:
    """One row a scene and variant."""
    return csv_table(
        [
            {
                "scene": one.scene,
                "variant": one.variant,
                "status": one.status,
                "certified": one.certified,
                "clearance": one.clearance,
                "iterations": one.iterations,
                "seconds": one.seconds,
                "over_best": one.over_best,
            }
            | {f"iterations_to_{s:g}": at for s, at in zip(NEAR, one.iterations_near, strict=True)}
            | {f"seconds_to_{s:g}": at for s, at in zip(NEAR, one.seconds_near, strict=True)}
            for one in outcomes
        ]
    )


def markdown_text(outcomes: Sequence[Convergence]) -> str:
    """One row a variant: medians over all its scenes, a dash where it came near on less than half."""
    rows = [
        _cells(variant, [one for one in outcomes if one.variant == variant])
        for variant in dict.fromkeys(one.variant for one in outcomes)
    ]
    return table(_HEAD, rows)


def _cells(variant: str, ones: Sequence[Convergence]) -> tuple[str, ...]:
    cells = [variant, str(len(ones)), str(sum(one.failed for one in ones))]
    for level in range(len(NEAR)):
        near = [one for one in ones if not np.isnan(one.iterations_near[level])]
        cells += [
            str(len(near)),
            number(_median([one.iterations_near[level] for one in ones]), ".0f"),
            number(_median([one.seconds_near[level] for one in ones]), ".2f"),
        ]
    cells.append(number(100.0 * _median([one.over_best for one in ones]), ".2f"))
    cells.append(number(1e3 * min(one.clearance for one in ones), ".2g"))
    return tuple(cells)


def _median(values: Sequence[float]) -> float:
    """With nan for infinity: what was never reached is later than anything else."""
    middle = float(np.median(np.nan_to_num(values, nan=np.inf)))
    return middle if np.isfinite(middle) else np.nan


def picture(outcomes: Sequence[Convergence]) -> bytes:
    """PNG: the share of scenes near the best cost over iterations, a line a variant."""
    profiles = {
        variant: [one.iterations_near[0] for one in outcomes if one.variant == variant]
        for variant in dict.fromkeys(one.variant for one in outcomes)
    }
    title = f"scenes within {100 * NEAR[0]:g} % of their best cost"
    return profile_figure(title, "iterations", profiles)
