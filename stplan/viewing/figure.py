"""The figure of a run: its map, what happens over time, its rods in space and time."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from stplan.analysis.tightness import pair_spots, wall_spots
from stplan.viewing.drawing import MUTED, WARNING, look, view_box
from stplan.viewing.figure_map import draw_map
from stplan.viewing.figure_rods import draw_rods
from stplan.viewing.figure_time import draw_arrivals, draw_clearance, draw_speed
from stplan.viewing.run_view import RunView
from stplan.wording import metres

PARTS = ("map", "time", "rods")
AXES_PARTS = ("map", "clearance", "speed", "arrivals", "rods")
FORMATS = ("png", "svg", "pdf")
_WIDTH = 13.0
_HEAD = 0.6
# Maps at least so much wider than high get a row of their own.
_WIDE = 3.2


def figure_bytes(
    view: RunView,
    kind: str,
    *,
    parts: tuple[str, ...] = PARTS,
    seed: bool = False,
    dpi: float = 150.0,
) -> bytes:
    """The figure of `view` as a file of `kind`, one of `FORMATS`.

    Args:
        parts: which of `PARTS` to show.
        seed: draw the initial curves behind the map.
        dpi: pixels an inch, for PNG and for what is shaded in the others.
    """
    metadata: dict[str, Any] = {
        "png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None},
    }[kind]  # fmt: skip
    with look():
        figure = draw_figure(view, parts=parts, seed=seed)
        stream = io.BytesIO()
        figure.savefig(stream, format=kind, dpi=dpi, metadata=metadata)
    return stream.getvalue()


def draw_figure(view: RunView, *, parts: tuple[str, ...] = PARTS, seed: bool = False) -> Figure:
    """Lay the parts out: map and rods above (a wide map alone), panels over time below."""
    xmin, ymin, xmax, ymax = view_box(view)
    aspect = (xmax - xmin) / max(ymax - ymin, 1e-9)
    alone = "map" in parts and (aspect >= _WIDE or "rods" not in parts)
    panels = ["clearance", "speed", "arrivals"] if "time" in parts else []
    above: list[str] = [name for name in ("map", "rods") if name in parts]
    if alone:
        above, panels = above[:1], above[1:] + panels
    rows = [row for row in (above, panels) if row]
    heights = [_row_height(row, aspect) for row in rows]
    figure = Figure(figsize=(_WIDTH, _HEAD + sum(heights)), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.08)
    head, *bands = figure.subfigures(len(rows) + 1, 1, height_ratios=[_HEAD, *heights])
    _draw_head(head, view)
    labels = []
    for band, row in zip(bands, rows, strict=True):
        ratios = [_share(name, row, aspect) for name in row]
        grid = band.add_gridspec(1, len(row), width_ratios=ratios)
        for column, name in enumerate(row):
            three = {"projection": "3d"} if name == "rods" else {}
            axes = band.add_subplot(grid[0, column], **three)
            if name == "map":
                labels.append(draw_map(axes, view, seed=seed))
            else:
                _DRAW[name](axes, view)
    figure.draw_without_rendering()
    for each in labels:
        each.settle()
    return figure


def new_axes(part: str) -> Axes:
    """Axes for one of `AXES_PARTS` in a figure of their own."""
    axes: Axes = Figure(layout="constrained").add_subplot(
        projection="3d" if part == "rods" else None
    )
    return axes


def draw_part(axes: Axes, view: RunView, part: str, *, seed: bool = False) -> None:
    """Fill `axes` of somebody's figure with one of `AXES_PARTS`; `rods` needs axes in 3D."""
    with look():
        if part != "map":
            _DRAW[part](axes, view)
            return
        labels = draw_map(axes, view, seed=seed)
        axes.get_figure(root=True).draw_without_rendering()
        labels.settle()


def _row_height(row: list[str], aspect: float) -> float:
    """In inches, such that the map fills the width it is given."""
    if row == ["map"]:
        return min(max((_WIDTH - 0.6) / aspect + 0.5, 1.6), 9.0)
    if "map" in row:
        return min(max(0.57 * _WIDTH / aspect + 0.5, 4.6), 6.8)
    return 4.8 if row == ["rods"] else 3.7


def _share(name: str, row: list[str], aspect: float) -> float:
    if name == "map" and len(row) > 1:
        return 1.0 + 0.35 * max(aspect - 1.0, 0.0)
    return 0.9 if name == "rods" else 1.0


_DRAW: dict[str, Any] = {
    "rods": draw_rods,
    "clearance": draw_clearance,
    "speed": draw_speed,
    "arrivals": draw_arrivals,
}


def _draw_head(band: SubFigure, view: RunView) -> None:
    """Name, what the scene shows, and how tight it is."""
    tightest = min(
        [*pair_spots(view.crowd)[:1], *wall_spots(view.crowd)[:1]],
        key=lambda spot: spot.clearance,
        default=None,
    )
    title = view.title + (f" — {view.description}" if view.description else "")
    band.text(0.012, 0.74, title, va="center", fontsize=13, fontweight="bold")
    facts = [f"{view.num_agents} agents" if view.num_agents > 1 else "one agent"]
    facts.append(f"all arrived after {view.end:.4g} s")
    colour = MUTED
    if tightest is not None:
        facts.append(f"smallest clearance {metres(tightest.clearance)} at {tightest.time:.4g} s")
        colour = MUTED if tightest.clearance > 0 else WARNING
    band.text(0.012, 0.26, ", ".join(facts), va="center", fontsize=9.5, color=colour)
