"""Gaps between the ends of walls drawn as lines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.maps.floor import polylines


def bridges(walls: Sequence[FloatArray], width: float) -> list[FloatArray]:
    """Lines (2, 2) from every loose end of the `walls` (n, 2) to the nearest other wall within `width`, m.

    An end is loose where no other wall touches it. Bridges only take floor away.
    """
    if not walls:
        return []
    shapes = polylines(walls)
    tree = shapely.STRtree(shapes)
    ends = np.array([point for line in walls for point in (line[0], line[-1])])
    owner = np.repeat(np.arange(len(walls)), 2)
    closed = np.array([(line[0] == line[-1]).all() for line in walls])
    points = shapely.points(ends)
    end, wall = tree.query(points, predicate="dwithin", distance=width)
    other = owner[end] != wall
    end, wall = end[other], wall[other]
    gap = shapely.distance(points[end], shapes[wall])
    found = []
    for k in range(len(ends)):
        near = np.flatnonzero(end == k) if len(end) < 10_000 else _slice(end, k)
        if closed[owner[k]] or not len(near) or gap[near].min() == 0:
            continue
        nearest = near[np.argmin(gap[near])]
        bridge = shapely.get_coordinates(shapely.shortest_line(points[k], shapes[wall[nearest]]))
        if (bridge[0] != bridge[1]).any():
            found.append(bridge)
    return found


def _slice(ends: FloatArray, k: int) -> FloatArray:
    """Where the sorted `ends` are `k`."""
    low, high = np.searchsorted(ends, [k, k + 1])
    return np.arange(low, high)
