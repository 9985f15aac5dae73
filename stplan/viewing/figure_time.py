"""A run over time: clearance of the tightest pairs, speeds, arrivals."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from stplan.analysis.paths import segment_speeds
from stplan.analysis.tightness import TightSpot, pair_spots, wall_spots
from stplan.analysis.waiting import waits
from stplan.arrays import FloatArray, IntArray
from stplan.viewing.clearances import pair_clearance, smallest_clearance
from stplan.viewing.drawing import FAINT, INK, MUTED, WALL, WARNING
from stplan.viewing.palette import hex_colours
from stplan.viewing.run_view import RunView
from stplan.wording import metres

_PAIRS = 5
_SAMPLES = 600
# Rows with names up to so many agents; single curves of speed up to so many.
_NAMED = 24
_SINGLE = 40


def draw_clearance(axes: Axes, view: RunView) -> None:
    """Clearance of the tightest pairs, of the rest and of the walls, over time against zero."""
    pairs, walls = pair_spots(view.crowd), wall_spots(view.crowd)
    times = np.linspace(view.begin, view.end, _SAMPLES)
    times = np.union1d(times, [spot.time for spot in pairs[:_PAIRS]])
    colours = hex_colours(view.num_agents)
    axes.set_title("Clearance")
    axes.set_ylabel("m")
    axes.axhline(0.0, color=WARNING, lw=1.2, zorder=2)
    handles: list[tuple[Line2D, ...]] = []
    labels: list[str] = []
    between, to_walls = smallest_clearance(view, times)
    if walls:
        line = axes.plot(times, _finite(to_walls), color=WALL, lw=1.0, ls=(0, (4, 2)))
        handles.append(tuple(line))
        labels.append(f"{walls[0].who[0]} and a wall: {metres(walls[0].clearance)}")
    for spot in pairs[:_PAIRS]:
        a, b = (view.rows[name] for name in spot.who)
        curve = pair_clearance(view, a, b, times)
        whole = axes.plot(times, curve, color=colours[a], lw=1.7)
        dashes = axes.plot(times, curve, color=colours[b], lw=1.7, ls=(0, (3, 3)))
        handles.append((*whole, *dashes))
        labels.append(f"{' and '.join(spot.who)}: {metres(spot.clearance)}")
        axes.plot(spot.time, spot.clearance, "o", ms=4, color=INK, zorder=4)
    if len(pairs) > _PAIRS:
        line = axes.plot(times, _finite(between), color=FAINT, lw=4.0, zorder=1)
        handles.append(tuple(line))
        labels.append("tightest of all pairs")
    _limit(axes, view, [*pairs[:_PAIRS], *walls[:1]], between)
    if pairs or walls:
        axes.legend(
            handles, labels, loc="upper left", bbox_to_anchor=(-0.06, -0.13), ncols=2,
            handlelength=2.2, columnspacing=1.2, handler_map={tuple: HandlerTuple(ndivide=1, pad=0)},
        )  # fmt: skip
    else:
        axes.text(0.5, 0.5, "nobody keeps a distance", transform=axes.transAxes, ha="center",
                  color=MUTED)  # fmt: skip


def _finite(values: FloatArray) -> FloatArray:
    return np.where(np.isfinite(values), values, np.nan)


def _limit(axes: Axes, view: RunView, spots: list[TightSpot], between: FloatArray) -> None:
    """Show what is near zero, however far apart agents are most of the time."""
    least = min((spot.clearance for spot in spots), default=0.0)
    near = 5 * float(np.median(view.radii))
    widest = float(np.max(between, where=np.isfinite(between), initial=0.0))
    top = max(near, 1.5 * max((spot.clearance for spot in spots), default=0.0))
    top = min(top, max(1.1 * widest, near / 5))
    bottom = min(-0.06 * top, 1.2 * least)
    axes.set_ylim(bottom, top)
    axes.set_xlim(view.begin, max(view.end, view.begin + 1e-9))
    axes.axhspan(bottom, 0.0, color=WARNING, alpha=0.08, lw=0)
    axes.set_xlabel("time, s", loc="right", labelpad=1)
    _mark_events(axes, view)


def _mark_events(axes: Axes, view: RunView, *, named: bool = False) -> None:
    """An upright line where something happened, with what it was where it is `named`."""
    for when, what in view.events:
        axes.axvline(when, color=INK, lw=0.9, ls=(0, (1, 2)), zorder=3, gid="event")
        if named:
            axes.annotate(
                what, (when, 1.0), xycoords=("data", "axes fraction"), xytext=(3, -2), fontsize=6,
                textcoords="offset points", va="top", color=INK, zorder=5, clip_on=True,
            )  # fmt: skip


def draw_speed(axes: Axes, view: RunView) -> None:
    """Speed of everyone over time; of very many the median and the middle half as well."""
    axes.set_title("Speed")
    axes.set_ylabel("m/s")
    axes.set_xlabel("time, s", loc="right", labelpad=1)
    single = view.num_agents <= _SINGLE
    steps = [
        np.column_stack([np.repeat(curve[:, 2], 2)[1:-1], np.repeat(segment_speeds(curve), 2)])
        for curve in view.lines.curves()
    ]
    axes.add_collection(
        LineCollection(
            steps, colors=hex_colours(view.num_agents), linewidths=1.3 if single else 0.6,
            alpha=0.9 if single else 0.25,
        ),
        autolim=False,
    )  # fmt: skip
    if not single:
        times, low, middle, high = _quartiles(view)
        axes.fill_between(times, low, high, color=INK, alpha=0.12, lw=0, label="middle half")
        axes.plot(times, middle, color=INK, lw=1.6, label="median")
        axes.legend(loc="upper right")
    fastest = max(float(segment_speeds(curve).max()) for curve in view.lines.curves())
    axes.set_ylim(0.0, 1.08 * fastest if fastest > 0 else 1.0)
    axes.set_xlim(view.begin, max(view.end, view.begin + 1e-9))
    _mark_events(axes, view)


def _quartiles(view: RunView) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Times, and the quartiles of the speeds of all who are on their way then."""
    times = np.linspace(view.begin, view.end, 202)[1:-1]
    speeds = np.full((view.num_agents, len(times)), np.nan)
    for a, curve in enumerate(view.lines.curves()):
        under_way = (times >= curve[0, 2]) & (times < curve[-1, 2])
        segment = np.searchsorted(curve[:, 2], times[under_way], side="right") - 1
        speeds[a, under_way] = segment_speeds(curve)[segment]
    times = times[~np.isnan(speeds).all(axis=0)]
    speeds = speeds[:, ~np.isnan(speeds).all(axis=0)]
    low, middle, high = np.nanpercentile(speeds, [25, 50, 75], axis=0)
    return times, low, middle, high


def _draw_bars(
    axes: Axes, rows: IntArray, begins: FloatArray, ends: FloatArray, height: float, **style: Any
) -> None:
    """Bars (N,) along time, as one artist: thousands of them take half a minute."""
    low, high = rows - 0.5 * height, rows + 0.5 * height
    corners = [(begins, low), (ends, low), (ends, high), (begins, high)]
    shapes = np.stack([np.column_stack(corner) for corner in corners], axis=1)
    axes.add_collection(PolyCollection(shapes, linewidths=0, **style), autolim=False)


def draw_arrivals(axes: Axes, view: RunView) -> None:
    """From start to arrival, a row an agent; waits are open, wanted arrivals are diamonds."""
    axes.set_title("On the way, waiting, arrived")
    axes.set_xlabel("time, s", loc="right", labelpad=1)
    colours = hex_colours(view.num_agents)
    rows = np.arange(view.num_agents)
    thickness = 0.6 if view.num_agents <= _SINGLE else 0.9
    begins = view.lines.knots[view.lines.offsets[:-1], 2]
    _draw_bars(axes, rows, begins, view.arrivals, thickness, facecolors=colours)
    found = waits(view.crowd)
    places = np.array([view.rows[wait.agent] for wait in found], dtype=np.int64)
    begun = np.array([wait.begin for wait in found])
    ended = np.array([wait.end for wait in found])
    _draw_bars(axes, places, begun, ended, 0.7 * thickness, facecolors="white", alpha=0.78)
    for wait, place in zip(found, places.tolist(), strict=True):
        if wait.meeting is not None and view.num_agents <= _NAMED:
            axes.text(
                0.5 * (wait.begin + wait.end), place, wait.meeting.agent, fontsize=6,
                ha="center", va="center", clip_on=True, color=INK,
            )  # fmt: skip
    wished = ~np.isnan(view.crowd.preferred)
    axes.scatter(
        view.crowd.preferred[wished], rows[wished], marker="D", s=22, c="white", edgecolors=INK,
        linewidths=1.0, zorder=4, label="wanted arrival",
    )  # fmt: skip
    if view.num_agents <= _NAMED:
        axes.set_yticks(rows, view.lines.agent_ids)
        axes.tick_params(axis="y", length=0, labelcolor=INK)
        for row, arrival in zip(rows, view.arrivals, strict=True):
            axes.annotate(
                f"{arrival:.1f}", (arrival, row), xytext=(4, 0), textcoords="offset points",
                fontsize=7, va="center", color=MUTED,
            )  # fmt: skip
    else:
        axes.set_ylabel(f"{view.num_agents} agents")
        axes.set_yticks([])
    axes.set_ylim(view.num_agents - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    latest = max(view.end, float(np.max(view.crowd.preferred[wished], initial=view.end)))
    axes.set_xlim(view.begin, latest + 0.08 * (latest - view.begin))
    _mark_events(axes, view, named=True)
    if wished.any():
        axes.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.13), handletextpad=0.2)
