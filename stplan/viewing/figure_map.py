"""The map of a run: swept paths at true scale, discs at equal times, start and goal marks."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection, PathCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Annotation, Text

from stplan.analysis.paths import positions
from stplan.problem.world_lines import WorldLines
from stplan.viewing.drawing import (
    FAINT,
    INK,
    MUTED,
    draw_ground,
    outline,
    scale_bar,
    thin_out,
    view_box,
)
from stplan.viewing.palette import hex_colours
from stplan.viewing.run_view import RunView
from stplan.viewing.ticks import nice_step

# About so many discs a path; from so many agents on none, and no names.
_MOMENTS = 9
_MANY = 60
# A time is written into a disc that is at least so many points wide.
_ROOM = 11.0


@dataclass
class MapLabels:
    """Names and times on a map: where they fit is known only when the figure is laid out."""

    axes: Axes
    names: list[Annotation] = field(default_factory=list)
    times: list[tuple[Text, float]] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)

    def settle(self) -> None:
        """Put names above their discs, drop times without room and all that would overlap."""
        scale = _points_per_metre(self.axes)
        for name, radius in zip(self.names, self.radii, strict=True):
            name.set_position((0.0, 4.0 + radius * scale))
        for text, radius in self.times:
            if 2 * radius * scale < _ROOM:
                text.remove()
        roomy = [text for text, radius in self.times if 2 * radius * scale >= _ROOM]
        thin_out([*self.names, *roomy], [])


def draw_map(axes: Axes, view: RunView, *, seed: bool = False) -> MapLabels:
    """Fill `axes` with the map of `view`, with its initial curves where `seed` asks for them.

    The labels returned are to be settled once the figure is laid out.
    """
    box = view_box(view)
    draw_ground(axes, view, box)
    scale_bar(axes, box, nice_step(box[2] - box[0], 12))
    colours = hex_colours(view.num_agents)
    labels = MapLabels(axes)
    many = view.num_agents > _MANY
    _draw_swaths(axes, view, colours)
    if seed and view.seed is not None:
        _draw_seed(axes, view, view.seed, colours)
    step = nice_step(view.end - view.begin, _MOMENTS)
    if not many:
        _draw_discs(axes, view, colours, step, labels)
        _draw_names(axes, view, labels)
    _draw_marks(axes, view, colours)
    _explain(axes, view, None if many else step, seed=seed and view.seed is not None)
    return labels


def _draw_swaths(axes: Axes, view: RunView, colours: list[str]) -> None:
    """What every disc passes over, pale, and the way of its centre."""
    ways = [curve[:, :2] for curve in view.lines.curves()]
    swaths = shapely.buffer([shapely.linestrings(way) for way in ways], view.radii, quad_segs=12)
    # One collection of each, which takes a tenth of the time that thousands of artists would.
    axes.add_collection(
        PathCollection(
            [outline(swath) for swath in swaths],
            facecolors=[to_rgba(colour, 0.13) for colour in colours], edgecolors="none", zorder=2,
        ),
        autolim=False,
    )  # fmt: skip
    axes.add_collection(
        LineCollection(ways, colors=colours, linewidths=1.1, alpha=0.9, zorder=3), autolim=False
    )


def _draw_seed(axes: Axes, view: RunView, seed: WorldLines, colours: list[str]) -> None:
    colour = dict(zip(view.lines.agent_ids, colours, strict=True))
    known = [a for a, agent_id in enumerate(seed.agent_ids) if agent_id in colour]
    curves = [seed.curve(a)[:, :2] for a in known]
    colours = [colour[seed.agent_ids[a]] for a in known]
    axes.add_collection(
        LineCollection(curves, colors=colours, linestyles=(0, (1, 1.2)), linewidths=1.2, zorder=3)
    )


def _draw_discs(
    axes: Axes, view: RunView, colours: list[str], step: float, labels: MapLabels
) -> None:
    """Everybody's disc every `step` s while under way, darker when later, with the time on it."""
    moments = np.arange(np.ceil(view.begin / step), np.floor(view.end / step) + 1) * step
    places = positions(view.lines, view.arrivals, moments)
    span = max(view.end - view.begin, 1e-9)
    discs, fills, rims = [], [], []
    for a, colour in enumerate(colours):
        radius, begin = float(view.radii[a]), view.lines.curve(a)[0, 2]
        for place, time in zip(places[a], moments.tolist(), strict=True):
            if np.isnan(place[0]):
                continue
            discs.append(Circle((place[0], place[1]), radius))
            fills.append(to_rgba(colour, 0.08 + 0.5 * (time - view.begin) / span))
            rims.append(to_rgba(colour, 0.9))
            if time <= begin:
                continue  # The mark of the start stands there.
            text = axes.text(
                *place, f"{time:g}", fontsize=6.5, ha="center", va="center", zorder=6, clip_on=True
            )
            labels.times.append((text, radius))
    axes.add_collection(
        PatchCollection(discs, facecolors=fills, edgecolors=rims, linewidths=0.6, zorder=4)
    )


def _points_per_metre(axes: Axes) -> float:
    axes.apply_aspect()
    ends = axes.transData.transform([[0.0, 0.0], [1.0, 0.0]])
    figure = axes.get_figure(root=True)
    return float(ends[1, 0] - ends[0, 0]) * 72.0 / figure.dpi


def _draw_marks(axes: Axes, view: RunView, colours: list[str]) -> None:
    ends = view.lines.knots[view.lines.offsets[1:] - 1]
    starts = view.lines.knots[view.lines.offsets[:-1]]
    size = 26.0 if view.num_agents <= 20 else 12.0 if view.num_agents <= _MANY else 5.0
    axes.scatter(
        starts[:, 0], starts[:, 1], s=size, c="white", edgecolors=colours, linewidths=1.4, zorder=5
    )
    axes.scatter(
        ends[:, 0], ends[:, 1], s=1.5 * size, c=colours, marker="X", edgecolors="white",
        linewidths=0.6, zorder=5,
    )  # fmt: skip
    for points, colour in zip(view.waypoints, colours, strict=True):
        for x, y in points:
            axes.plot(x, y, marker="D", ms=4, mfc="white", mec=colour, mew=1.2, zorder=5)


def _draw_names(axes: Axes, view: RunView, labels: MapLabels) -> None:
    starts = view.lines.knots[view.lines.offsets[:-1]]
    labels.radii = view.radii.tolist()
    labels.names = [
        axes.annotate(
            name, (x, y), xytext=(0.0, 4.0), textcoords="offset points", fontsize=7.5, ha="center",
            va="bottom", color=INK, zorder=7, annotation_clip=False,
        )
        for name, (x, y, _) in zip(view.lines.agent_ids, starts, strict=True)
    ]  # fmt: skip
    for name in labels.names:
        name.set_in_layout(False)


def _explain(axes: Axes, view: RunView, step: float | None, *, seed: bool) -> None:
    """The key below the map: what the marks mean."""
    plain = {"color": MUTED, "ls": "none", "mew": 1.2}
    handles = [
        Line2D([], [], marker="o", ms=5, mfc="white", label="start", **plain),
        Line2D([], [], marker="X", ms=6, mec="white", label="goal", color=MUTED, ls="none"),
    ]
    if any(view.waypoints):
        handles.append(Line2D([], [], marker="D", ms=4, mfc="white", label="waypoint", **plain))
    if step is not None:
        label = f"every {step:g} s, darker when later"
        handles.append(Line2D([], [], marker="o", ms=8, mfc=FAINT, label=label, **plain))
    if seed:
        handles.append(Line2D([], [], color=MUTED, ls=(0, (1, 1.2)), lw=1.2, label="initial curve"))
    axes.legend(
        handles=handles, loc="upper right", bbox_to_anchor=(1.0, 0.0), ncols=len(handles),
        handletextpad=0.4, columnspacing=1.4, borderaxespad=0.3, labelcolor=MUTED,
    )  # fmt: skip
