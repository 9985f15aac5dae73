"""The paper's scenes and plots as CSV, Markdown and figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from stplan.bench.csv_table import csv_table
from stplan.bench.deviations import Snapping, Trial, deviations_text
from stplan.bench.markdown import number, table
from stplan.bench.paper import PLOTS, WAYS, Compared, IterationTimes, growths
from stplan.bench.plots import Series, growth_figure
from stplan.bench.result_files import result_files
from stplan.bench.scaling import Sweep
from stplan.bench.solves import PricedSolve

_HEAD = (
    "scene",
    "the paper's",
    "agents",
    "default: cost",
    "iterations",
    "s",
    "paper: cost",
    "iterations",
    "s",
    "outcome",
    "cost over default's",
)


def files(
    compared: Sequence[Compared],
    timings: Sequence[IterationTimes],
    outcomes: Sequence[Trial],
    snapping: Snapping,
) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    text = f"{_scenes(compared)}\n{_plots(timings)}"
    pictures = {f"{plot.name}.png": _picture(plot, timings) for plot in PLOTS}
    deviations = result_files(
        "paper_deviations",
        csv_table([asdict(one) for one in outcomes]),
        deviations_text(outcomes, snapping),
    )
    return result_files("paper", _csv(compared), text) | deviations | pictures


def _csv(compared: Sequence[Compared]) -> str:
    """A row for each scene and recipe."""
    return csv_table(
        [
            {"scene": one.scene, "recipe": name, "cost": recipe.cost, "seconds": recipe.seconds}
            | asdict(recipe.figures)
            for one in compared
            for name, recipe in (("default", one.default), ("paper", one.paper))
        ]
    )


def _scenes(compared: Sequence[Compared]) -> str:
    rows = [
        (
            one.scene,
            one.shows,
            str(one.default.figures.agents),
            *_cells(one.default),
            *_cells(one.paper),
            one.paper.figures.status.partition(":")[0],
            number(one.paper.cost / one.default.cost, ".3f"),
        )
        for one in compared
    ]
    planned = sum(one.paper.figures.certified for one in compared)
    count = f"The paper's recipe plans {planned} of {len(compared)} scenes."
    reasons = "".join(
        f"\n- {one.scene}: {one.paper.figures.status}"
        for one in compared
        if not one.paper.figures.certified
    )
    listed = f" It does not plan:\n{reasons}" if reasons else ""
    return f"{table(_HEAD, rows, (0, 1, 9))}\n{count}{listed}\n"


def _cells(recipe: PricedSolve) -> tuple[str, str, str]:
    figures = recipe.figures
    return number(recipe.cost, ".5g"), str(figures.iterations), f"{recipe.seconds:.1f}"


def _plots(timings: Sequence[IterationTimes]) -> str:
    """Milliseconds an iteration and contacts, a table a plot, with fitted exponents below."""
    parts = []
    for plot in PLOTS:
        own = [one for one in timings if one.plot == plot.name]
        rows = [
            (
                str(one.size),
                *(number(1e3 * one.seconds[way], ".1f") for way in WAYS),
                *(str(one.contacts[way]) for way in WAYS),
            )
            for one in own
        ]
        powers = growths(timings, plot.name)
        exponents = [powers[way][part] for part in range(2) for way in WAYS]
        rows.append(("exponent", *(number(one, ".2f") for one in exponents)))
        head = (plot.size, *(f"{way}, ms" for way in WAYS), *(f"{way}, contacts" for way in WAYS))
        parts.append(f"{plot.title}\n\n{table(head, rows)}")
    return "\n".join(parts)


def _picture(plot: Sweep, timings: Sequence[IterationTimes]) -> bytes:
    own = [one for one in timings if one.plot == plot.name]
    powers = growths(timings, plot.name)
    series = [
        Series(
            way,
            [float(one.size) for one in own],
            [1e3 * one.seconds[way] for one in own],
            powers[way][0],
        )
        for way in WAYS
    ]
    return growth_figure(plot.title, plot.size, "time of an iteration, ms", series)
