"""How near agents come to one another and to walls: the tightest moments, and over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.certify.pair_clearance import nearest_moments
from stplan.certify.wall_clearance import time_at, wall_distance
from stplan.viewing.motion import positions
from stplan.viewing.run_view import RunView


@dataclass(frozen=True)
class TightMoment:
    """Where a pair, or an agent and a wall, is tightest: of whom, m, s, m."""

    who: tuple[int, ...]
    clearance: float
    time: float
    place: tuple[float, float]


def tight_pairs(view: RunView) -> list[TightMoment]:
    """The tightest moment of every pair that keeps its distance, tightest first; exact."""
    found = nearest_moments(view.lines, view.leaves, view.collides)
    together = np.isfinite(found.distance)
    a, b = found.pairs[together].T
    time = found.instant[together]
    clearance = found.distance[together] - view.distance[a, b]
    place = _between(view, a, b, time)
    moments = [
        TightMoment((first, second), *row)
        for first, second, *row in zip(
            a.tolist(), b.tolist(), clearance.tolist(), time.tolist(), place, strict=True
        )
    ]
    return sorted(moments, key=lambda moment: moment.clearance)


def _between(
    view: RunView, a: IntArray, b: IntArray, time: FloatArray
) -> list[tuple[float, float]]:
    """The points (P,) between pairs of agents that divide their distance as their radii do."""
    curves = list(view.lines.curves())
    ends = [
        [
            [np.interp(when, curves[agent][:, 2], curves[agent][:, axis]) for axis in range(2)]
            for agent, when in zip(agents.tolist(), time.tolist(), strict=True)
        ]
        for agents in (a, b)
    ]
    first, second = np.array(ends).reshape(2, -1, 2)
    share = view.radii[a] / (view.radii[a] + view.radii[b])
    points = first + share[:, None] * (second - first)
    return [(x, y) for x, y in points.tolist()]


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
            moments.append(TightMoment((a,), clearance, time_at(curve, place), (x, y)))
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
