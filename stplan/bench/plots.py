"""Figures of measurements; the only room of the benchmarks that loads matplotlib."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stplan.optional import require

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKERS = "osD^v<>P"


@dataclass(frozen=True)
class Series:
    """Values over sizes, and the exponent fitted to them (nan where there is none)."""

    label: str
    sizes: Sequence[float]
    values: Sequence[float]
    exponent: float = np.nan


def require_matplotlib() -> None:
    """Ask for matplotlib before anything is measured.

    Raises:
        UsageError: it is not installed.
    """
    require("matplotlib.figure", "a figure of a benchmark", extra="docs")


def growth_figure(title: str, size: str, value: str, series: Sequence[Series]) -> bytes:
    """PNG of values over sizes, both logarithmic, with the fitted powers as lines."""
    figure, axes = _axes(title)
    for marker, one in zip(_MARKERS, series, strict=False):
        fitted = not np.isnan(one.exponent)
        label = f"{one.label}, exponent {one.exponent:.2f}" if fitted else one.label
        (points,) = axes.loglog(one.sizes, one.values, marker, label=label)
        if fitted:
            sizes = np.array(one.sizes)
            level = np.exp(np.mean(np.log(one.values) - one.exponent * np.log(sizes)))
            axes.loglog(sizes, level * sizes**one.exponent, color=points.get_color(), alpha=0.6)
    axes.set_xlabel(size)
    axes.set_ylabel(value)
    axes.grid(which="both", alpha=0.2)
    axes.legend()
    return _png(figure)


def profile_figure(title: str, work: str, profiles: Mapping[str, Sequence[float]]) -> bytes:
    """PNG of the share of scenes finished (%) over the work it took; nan is never finished."""
    figure, axes = _axes(title)
    most = max((cost for costs in profiles.values() for cost in costs if cost > 0.0), default=1.0)
    for label, costs in profiles.items():
        done = np.sort([cost for cost in costs if not np.isnan(cost)])
        share = 100.0 * np.arange(len(done) + 1) / max(len(costs), 1)
        axes.step([0.0, *done, 1.2 * most], [*share, share[-1]], where="post", label=label)
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set_ylim(0.0, 103.0)
    axes.set_xlabel(work)
    axes.set_ylabel("scenes, %")
    axes.grid(which="both", alpha=0.2)
    axes.legend(fontsize="small")
    return _png(figure)


def _axes(title: str) -> tuple[Figure, Axes]:
    # Without pyplot: no window system is asked for, nothing global is changed.
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.5), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(title, fontsize="medium")
    return figure, axes


def _png(figure: Figure) -> bytes:
    stream = io.BytesIO()
    # Without the version of matplotlib, that the same figure gives the same bytes.
    figure.savefig(stream, format="png", dpi=130, metadata={"Software": None})
    return stream.getvalue()
