"""Frames of a movie: discs at true radius over their maps, several runs side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import to_rgba, to_rgba_array
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stplan.analysis.paths import positions
from stplan.arrays import FloatArray
from stplan.viewing.drawing import FAINT, INK, MUTED, draw_ground, look, view_box
from stplan.viewing.palette import hex_colours
from stplan.viewing.run_view import RunView

_DPI = 100
# A trail shows this share of the whole time, in so many pieces that fade.
_TRAIL = 0.12
_PIECES = 14
# Names stand in discs at least so many pixels wide, of at most so many agents.
_ROOM = 26.0
_NAMED = 40
# Room for the title above and the time below, in pixels.
_HEAD = 34
_FOOT = 44


def default_height(views: Sequence[RunView], width: int) -> int:
    """The height in pixels at which `views` side by side fill a picture of `width` pixels."""
    aspects = [_aspect(view) for view in views]
    return int(np.clip(width / sum(aspects), 160, 1.2 * width)) + _HEAD + _FOOT


def _aspect(view: RunView) -> float:
    xmin, ymin, xmax, ymax = view_box(view)
    return float(np.clip((xmax - xmin) / max(ymax - ymin, 1e-9), 0.1, 10.0))


class Film:
    """Renders any moment of some runs.

    Args:
        titles: one a run, shown where there are several.
        size: width and height in pixels.
        note: shown beside the time.
    """

    def __init__(
        self, views: Sequence[RunView], titles: Sequence[str], size: tuple[int, int], note: str
    ) -> None:
        width, height = size
        self._begin = min(view.begin for view in views)
        self._end = max(view.end for view in views)
        with look():
            self._figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)
            self._canvas = FigureCanvasAgg(self._figure)
            grid = self._figure.add_gridspec(
                1, len(views), width_ratios=[_aspect(view) for view in views], wspace=0.02,
                left=0.01, right=0.99, bottom=_FOOT / height, top=1 - _HEAD / height,
            )  # fmt: skip
            self._stages = [
                _Stage(self._figure.add_subplot(grid[0, place]), view, title, self._end)
                for place, (view, title) in enumerate(zip(views, titles, strict=True))
            ]
            self._draw_foot(note, height)
        self._background = None

    def _draw_foot(self, note: str, height: int) -> None:
        """The time in figures and as a bar."""
        axes = self._figure.add_axes((0.01, 6 / height, 0.98, 4 / height))
        axes.set_axis_off()
        axes.set_xlim(self._begin, max(self._end, self._begin + 1e-9))
        axes.axhspan(0.0, 1.0, color=FAINT, lw=0)
        self._bar = axes.axvspan(self._begin, self._begin, color=MUTED, lw=0, animated=True)
        self._clock = self._figure.text(
            0.01, 16 / height, "", fontsize=12, fontweight="bold", color=INK, animated=True
        )
        self._figure.text(0.99, 17 / height, note, fontsize=9, color=MUTED, ha="right")

    def frame(self, time: float) -> NDArray[np.uint8]:
        """(height, width, 4) picture of the moment `time` s."""
        with look():
            return self._frame(time)

    def _frame(self, time: float) -> NDArray[np.uint8]:
        if self._background is None:
            self._canvas.draw()
            self._background = self._canvas.copy_from_bbox(self._figure.bbox)
            for stage in self._stages:
                stage.settle()
        self._canvas.restore_region(self._background)
        for stage in self._stages:
            for artist in stage.at(time):
                stage.axes.draw_artist(artist)
        self._bar.set_width(time - self._begin)
        self._clock.set_text(f"{time:.1f} s")
        for artist in (self._bar, self._clock):
            self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba()).copy()

    def frames(self, times: FloatArray) -> Iterator[NDArray[np.uint8]]:
        """The pictures of all `times`."""
        return (self.frame(float(time)) for time in times)


class _Stage:
    """One run on its map."""

    def __init__(self, axes: Axes, view: RunView, title: str, end: float) -> None:
        self.axes = axes
        self._view = view
        self._leaves = view.seen_until(end)
        self._trail = _TRAIL * max(view.end - view.begin, 1e-9)
        draw_ground(axes, view, view_box(view))
        axes.set_title(title)
        colours = hex_colours(view.num_agents)
        ends = view.lines.knots[view.lines.offsets[1:] - 1]
        axes.scatter(ends[:, 0], ends[:, 1], s=22, c=colours, marker="x", linewidths=1.2, zorder=2)
        fading = to_rgba_array(np.repeat(colours, _PIECES))
        fading[:, 3] = np.tile(np.linspace(0.0, 0.55, _PIECES), view.num_agents)
        self._trails = LineCollection([], colors=fading, linewidths=2.2, capstyle="butt")
        self._discs = EllipseCollection(
            2 * view.radii, 2 * view.radii, np.zeros(view.num_agents), units="xy",
            offsets=np.zeros((view.num_agents, 2)), offset_transform=axes.transData,
            facecolors=[to_rgba(colour, 0.78) for colour in colours], edgecolors=colours,
            linewidths=1.0,
        )  # fmt: skip
        for collection in (self._trails, self._discs):
            collection.set_animated(True)
            axes.add_collection(collection, autolim=False)
        self._names = [
            axes.text(0, 0, name, fontsize=7.5, ha="center", va="center", color="white",
                      animated=True, clip_on=True)
            for name in view.lines.agent_ids[: _NAMED + 1]
        ]  # fmt: skip

    def settle(self) -> None:
        """Keep the names that fit into their discs, once the scale of the map is known."""
        corners = self.axes.transData.transform([[0.0, 0.0], [1.0, 0.0]])
        widths = 2 * self._view.radii * (corners[1, 0] - corners[0, 0])
        for name, width in zip(self._names, widths.tolist(), strict=False):
            fits = name.get_window_extent().width <= 0.94 * width and width >= _ROOM
            name.set_visible(fits and self._view.num_agents <= _NAMED)

    def at(self, time: float) -> list[Artist]:
        """Everything that moves, as it is at `time` s."""
        view = self._view
        now = positions(view.lines, self._leaves, np.array([time]))[:, 0]
        self._discs.set_offsets(np.ma.masked_invalid(now))
        past = np.linspace(time - self._trail, time, _PIECES + 1)
        ways = positions(view.lines, self._leaves, past)
        pieces = np.stack([ways[:, :-1], ways[:, 1:]], axis=2).reshape(-1, 2, 2)
        self._trails.set_segments(pieces)
        for name, place in zip(self._names, now, strict=False):
            name.set_position((place[0], place[1]))
        there = [
            name
            for name, place in zip(self._names, now, strict=False)
            if name.get_visible() and not np.isnan(place[0])
        ]
        return [self._trails, self._discs, *there]
