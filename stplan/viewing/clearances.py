"""How near agents come to one another and to walls: the tightest moments, and over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.certify.pair_clearance import least_distances
from stplan.certify.wall_clearance import time_at, wall_distance
from stplan.viewing.motion import positions
from stplan.viewing.run_view import RunView


@dataclass(frozen=True)
class TightMoment:
    """Where a pair (or an agent and a wall, `b` is None) is tightest; m, s, m."""

    a: int
    b: int | None
    clearance: float
    time: float
    place: tuple[float, float]


def tight_pairs(view: RunView) -> list[TightMoment]:
    """The tightest moment of every pair that keeps its distance, tightest first; exact."""
    count = int(np.triu(view.collides).sum())
    pairs = np.empty((count, 2), dtype=np.int64)
    distance = np.empty(count)
    instant = np.empty(count)
    lines = view.lines
    least_distances(
        lines.knots, lines.offsets, view.leaves, view.collides, pairs, distance, instant
    )
    moments = []
    for (a, b), gap, when in zip(pairs.tolist(), distance.tolist(), instant.tolist(), strict=True):
        if np.isfinite(gap):
            clearance = gap - float(view.distance[a, b])
            moments.append(TightMoment(a, b, clearance, when, _between(view, a, b, when)))
    return sorted(moments, key=lambda moment: moment.clearance)


def _between(view: RunView, a: int, b: int, time: float) -> tuple[float, float]:
    """The point between two agents that divides their distance as their radii do."""
    share = float(view.radii[a] / (view.radii[a] + view.radii[b]))
    first, second = (
        [float(np.interp(time, curve[:, 2], curve[:, axis])) for axis in range(2)]
        for curve in (view.lines.curve(a), view.lines.curve(b))
    )
    return (
        first[0] + share * (second[0] - first[0]),
        first[1] + share * (second[1] - first[1]),
    )


def tight_walls(view: RunView) -> list[TightMoment]:
    """The tightest moment of every agent that heeds walls, tightest first; exact."""
    if view.free_space is None:
        return []
    moments = []
    for a, curve in enumerate(view.lines.curves()):
        if view.heeds_walls[a]:
            distance, place = wall_distance(view.free_space, curve)
            x, y = place.tolist()
            clearance = distance - float(view.radii[a])
            moments.append(TightMoment(a, None, clearance, time_at(curve, place), (x, y)))
    return sorted(moments, key=lambda moment: moment.clearance)


def pair_clearance(view: RunView, a: int, b: int, times: FloatArray) -> FloatArray:
    """(T,) clearance of one pair in m, NaN where not both are there."""
    places = positions(view.lines, view.leaves, times)
    gap: FloatArray = np.hypot(*(places[a] - places[b]).T)
    return gap - view.distance[a, b]


def smallest_clearance(view: RunView, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(T,) smallest clearance over all pairs, and over all agents to the walls, in m; inf for none."""
    places = positions(view.lines, view.leaves, times)
    between = np.full(len(times), np.inf)
    for k in range(len(times)):
        offset = places[:, None, k] - places[None, :, k]
        gap = np.hypot(offset[..., 0], offset[..., 1]) - view.distance
        gap[~view.collides | np.isnan(gap)] = np.inf
        between[k] = gap.min()
    return between, wall_clearance(view, places).min(axis=0)


def wall_clearance(view: RunView, places: FloatArray) -> FloatArray:
    """(A, T) clearance to the walls at `places` (A, T, 2) in m; inf for absent agents and no walls."""
    clearance = np.full(places.shape[:2], np.inf)
    if view.free_space is None:
        return clearance
    there = ~np.isnan(places[..., 0]) & view.heeds_walls[:, None]
    clearance[there] = view.free_space.clearance(places[there])
    return clearance - view.radii[:, None]
