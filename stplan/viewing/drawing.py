"""What figures and movies share: the look, the map, labels that do not overlap."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.text import Text
from matplotlib.transforms import Bbox, ScaledTranslation

from stplan.arrays import FloatArray
from stplan.viewing.run_view import RunView

INK = "#1f2328"
MUTED = "#7d858f"
FAINT = "#d9dde2"
SOLID = "#c3c8cf"
FLOOR = "#ffffff"
WALL = "#4a515a"
WARNING = "#d1242f"
PLACE = "#1a7f64"

_LOOK: dict[str, Any] = {
    # Names and descriptions are text, whatever dollars there are in them.
    "text.parse_math": False,
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": MUTED,
    "axes.labelsize": 8.5,
    "axes.edgecolor": FAINT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#eceff2",
    "text.color": INK,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "svg.fonttype": "none",
    "svg.hashsalt": "stplan",
    "pdf.fonttype": 42,
}


@contextmanager
def look() -> Iterator[None]:
    """Within, figures look as they should; letters that no font has are boxes, without complaint."""
    with mpl.rc_context(_LOOK), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font")
        yield


def outline(geometry: shapely.Geometry) -> Outline:
    """Polygons with holes as one path."""
    corners: list[FloatArray] = []
    codes: list[Any] = []
    for part in shapely.get_parts(geometry):
        for ring in (part.exterior, *part.interiors):
            points = np.asarray(ring.coords)[:, :2]
            corners.append(points)
            codes += [Outline.MOVETO, *[Outline.LINETO] * (len(points) - 2), Outline.CLOSEPOLY]
    return Outline(np.vstack(corners), codes)


def view_box(view: RunView) -> tuple[float, float, float, float]:
    """xmin, ymin, xmax, ymax with a small margin, m."""
    xmin, ymin, xmax, ymax = view.bounds
    margin = 0.025 * max(xmax - xmin, ymax - ymin)
    return xmin - margin, ymin - margin, xmax + margin, ymax + margin


def draw_ground(axes: Axes, view: RunView, box: tuple[float, float, float, float]) -> None:
    """Floor and walls at true scale, nothing else."""
    xmin, ymin, xmax, ymax = box
    axes.set_xlim(xmin, xmax)
    axes.set_ylim(ymin, ymax)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_facecolor(FLOOR if view.free_space is None else SOLID)
    for spine in axes.spines.values():
        spine.set_visible(view.free_space is None)
    axes.set_xticks([])
    axes.set_yticks([])
    if view.free_space is not None:
        axes.add_patch(
            PathPatch(outline(view.free_space.polygon), facecolor=FLOOR, edgecolor=WALL, lw=0.9)
        )
    _draw_places(axes, view)


def _draw_places(axes: Axes, view: RunView) -> None:
    """Parts of the plane in which agents start and end: dashed, with their names."""
    for place in view.places:
        points = np.array([*place.points, place.points[0]] if place.area else place.points)
        axes.plot(points[:, 0], points[:, 1], color=PLACE, lw=1.2, ls=(0, (4, 2)), zorder=1.5)
        if place.area:
            axes.fill(points[:, 0], points[:, 1], color=PLACE, alpha=0.08, lw=0, zorder=1.4)
        x, y = points.min(axis=0) if place.area else points.mean(axis=0)
        axes.annotate(
            place.name, (x, y), xytext=(3.0, 3.0), textcoords="offset points", fontsize=7.5,
            color=PLACE, zorder=6, clip_on=True,
        ).set_in_layout(False)  # fmt: skip


def scale_bar(axes: Axes, box: tuple[float, float, float, float], length: float) -> None:
    """A bar of `length` m below the lower left corner of the map."""
    figure = axes.get_figure(root=True)
    down = ScaledTranslation(0.0, -11.0 / 72.0, figure.dpi_scale_trans)
    below = axes.get_xaxis_transform() + down
    start, end = box[0], box[0] + length
    axes.plot(
        [start, end], [0.0, 0.0], transform=below, color=MUTED, lw=2.0, solid_capstyle="butt",
        clip_on=False,
    )  # fmt: skip
    axes.text(
        end, 0.0, f"  {length:g} m", transform=below, color=MUTED, fontsize=8, va="center",
        clip_on=False,
    )  # fmt: skip


def thin_out(texts: Iterable[Text], taken: list[Bbox]) -> None:
    """Remove every text that would cover an earlier one; what stays is added to `taken`."""
    for text in texts:
        box = text.get_window_extent().padded(0.5)
        if any(box.overlaps(other) for other in taken):
            text.remove()
        else:
            taken.append(box)
