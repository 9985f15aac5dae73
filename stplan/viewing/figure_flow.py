"""Flow figures drawn: who has arrived when, what crosses lines, and fundamental diagrams."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stplan.arrays import FloatArray

# Inches of one picture.
SIZE, DPI = (6.4, 4.2), 120
# A table of times, and its name.
Curve = tuple[str, FloatArray]


def evacuation_picture(evacuation: FloatArray, crossings: Sequence[Curve]) -> bytes:
    """PNG of how many have arrived, and crossed each line, over time.

    `evacuation` (T, 3) holds time, on the way and arrived; `crossings` (N, 2) time and number.
    """
    figure, axes = _axes("Evacuation", "time, s", "agents")
    axes.step(evacuation[:, 0], evacuation[:, 2], where="post", label="arrived")
    axes.step(evacuation[:, 0], evacuation[:, 1], where="post", label="on the way")
    for name, table in crossings:
        axes.step(table[:, 0], table[:, 1], where="post", ls="--", label=f"across {name}")
    axes.legend()
    return _png(figure)


def diagram_picture(areas: Sequence[Curve]) -> bytes:
    """PNG of the fundamental diagrams, speed over density: (T, 5) tables, see `AreaFigures`."""
    figure, axes = _axes("Fundamental diagram", "Voronoi density, 1/m²", "Voronoi speed, m/s")
    for name, rows in areas:
        there = rows[:, 2] > 0.0
        axes.plot(rows[there, 2], rows[there, 3], ".", ms=4, label=name)
    axes.legend()
    return _png(figure)


def density_picture(areas: Sequence[Curve]) -> bytes:
    """PNG of densities over time."""
    figure, axes = _axes("Density", "time, s", "Voronoi density, 1/m²")
    for name, rows in areas:
        axes.plot(rows[:, 0], np.nan_to_num(rows[:, 2]), label=name)
    axes.legend()
    return _png(figure)


def _axes(title: str, x: str, y: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_ylim(bottom=0.0, auto=True)
    axes.grid(alpha=0.3)
    return figure, axes


def _png(figure: Figure) -> bytes:
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=DPI, metadata={"Software": None})
    return target.getvalue()
