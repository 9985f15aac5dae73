"""How near agents come to one another and to walls over time, and where their rims are nearest."""

from __future__ import annotations

import numpy as np

from stplan.analysis.paths import place_at, positions
from stplan.analysis.tightness import TightSpot, pairs_to_look_at
from stplan.arrays import FloatArray
from stplan.viewing.run_view import RunView


def touching_point(view: RunView, spot: TightSpot) -> tuple[float, float]:
    """Where to mark a tight spot: between two rims, dividing their distance as the radii do; m."""
    if len(spot.who) == 1:
        return spot.place
    a, b = (view.rows[name] for name in spot.who)
    first, second = (np.array(place_at(view.lines.curve(k), spot.time)) for k in (a, b))
    share = view.radii[a] / (view.radii[a] + view.radii[b])
    x, y = (first + share * (second - first)).tolist()
    return x, y


def pair_clearance(view: RunView, a: int, b: int, times: FloatArray) -> FloatArray:
    """(T,) clearance of one pair in m, NaN where not both are there."""
    places = positions(view.lines, view.leaves, times)
    gap: FloatArray = np.hypot(*(places[a] - places[b]).T)
    return gap - view.crowd.distance[a, b]


def smallest_clearance(view: RunView, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(T,) smallest clearance over all pairs, and over all agents to the walls, in m; inf for none."""
    places = positions(view.lines, view.leaves, times)
    a, b = pairs_to_look_at(view.crowd).T
    needs, between = view.crowd.distance[a, b], np.full(len(times), np.inf)
    for k in range(len(times)):
        offset = places[a, k] - places[b, k]
        gap = np.hypot(offset[:, 0], offset[:, 1]) - needs
        between[k] = np.min(gap, where=~np.isnan(gap), initial=np.inf)
    return between, wall_clearance(view, places).min(axis=0)


def wall_clearance(view: RunView, places: FloatArray) -> FloatArray:
    """(A, T) clearance to the walls at `places` (A, T, 2) in m; inf for absent agents and no walls."""
    clearance = np.full(places.shape[:2], np.inf)
    if view.free_space is None:
        return clearance
    there = ~np.isnan(places[..., 0]) & view.crowd.heeds_walls[:, None]
    clearance[there] = view.free_space.clearance(places[there])
    return clearance - view.radii[:, None]
