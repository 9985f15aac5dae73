"""Simpler polygons inside given ones: corners are cut off, nothing is ever added."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray

# Each pass takes away at most every other corner; so many halve the longest ring to nothing.
MOST_PASSES = 64


def inner_polygons(polygons: FloatArray, tolerance: float) -> FloatArray:
    """Polygons (P,) with fewer corners, each inside its own, no point of whose outline moved further
    than `tolerance`.

    A corner is dropped where the polygon bulges: a line from neighbour to neighbour then lies inside. So
    stairs of cells become slopes along their inner corners. Corners that point inwards stay.
    """
    if tolerance <= 0 or not len(polygons):
        return polygons
    parts = shapely.get_parts(shapely.orient_polygons(polygons))
    rings, owner = shapely.get_rings(parts, return_index=True)
    shorter = _cut(rings, tolerance)
    grouped = np.split(shorter, np.flatnonzero(np.diff(owner)) + 1)
    made = np.array([shapely.polygons(group[0], group[1:]) for group in grouped], dtype=object)
    # Where cuts of two rings met, the polygon as it was is right.
    bad = ~shapely.is_valid(made)
    made[bad] = parts[bad]
    return made


def _cut(rings: FloatArray, tolerance: float) -> FloatArray:
    """The rings (R,) with bulges cut off; free space lies to the left of all of them."""
    corners, owner = shapely.get_coordinates(rings, return_index=True)
    # Without the last corner, which repeats the first.
    last = np.append(np.flatnonzero(np.diff(owner)), len(owner) - 1)
    keep = np.ones(len(corners), dtype=bool)
    keep[last] = False
    corners, owner = corners[keep], owner[keep]
    # How far the hidden corners of the edge from each corner to the next may be from it.
    hidden = np.zeros(len(corners))
    for _ in range(MOST_PASSES):
        before, after = _neighbours(owner)
        dropped, height = _bulges(corners, owner, before, after, hidden, tolerance)
        dropped = _empty(corners, dropped, before, after)
        dropped = _apart(dropped, height, before, after)
        if not dropped.any():
            break
        gone = np.flatnonzero(dropped)
        start = before[gone]
        hidden[start] = np.maximum(hidden[start], hidden[gone]) + height[gone]
        corners, owner, hidden = corners[~dropped], owner[~dropped], hidden[~dropped]
    return np.asarray(shapely.linearrings(corners, indices=owner))


def _neighbours(owner: FloatArray) -> tuple[Any, Any]:
    """Indices of the corner before and after every one in its ring."""
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    last = np.append(first[1:], len(owner)) - 1
    index = np.arange(len(owner))
    before, after = index - 1, index + 1
    before[first], after[last] = last, first
    return before, after


def _bulges(
    corners: FloatArray, owner: FloatArray, before: Any, after: Any, hidden: FloatArray,
    tolerance: float,
) -> tuple[BoolArray, FloatArray]:  # fmt: skip
    """Corners that may go, and how far each is from the line between its neighbours."""
    a, b, c = corners[before], corners, corners[after]
    ab, ac = b - a, c - a
    turn = ab[:, 0] * (c - b)[:, 1] - ab[:, 1] * (c - b)[:, 0]
    length = np.hypot(*ac.T)
    height = np.abs(turn) / np.maximum(length, np.finfo(float).tiny)
    along = (ab * ac).sum(axis=1)
    between = (along >= 0) & (along <= length**2)
    counts = np.bincount(owner)
    fits = np.maximum(hidden[before], hidden) + height <= tolerance
    return (turn >= 0) & between & fits & (counts[owner] > 4), height


def _apart(chosen: BoolArray, height: FloatArray, before: Any, after: Any) -> BoolArray:
    """Those of the `chosen` that go first: lowest among chosen neighbours, no two side by side."""
    rank = np.where(chosen, height, np.inf)
    index = np.arange(len(chosen))
    # Equal heights, as on stairs, go by place, every other one at least.
    odd = index % 2
    lower = np.ones(len(chosen), dtype=bool)
    for other in (before, after):
        lower &= (rank < rank[other]) | (
            (rank == rank[other]) & ((odd < odd[other]) | ((odd == odd[other]) & (index < other)))
        )
    return chosen & lower


def _empty(corners: FloatArray, chosen: BoolArray, before: Any, after: Any) -> BoolArray:
    """Those of the `chosen` whose triangles hold no other corner, nor meet another chosen triangle."""
    index = np.flatnonzero(chosen)
    if not len(index):
        return chosen
    triangles = shapely.polygons(
        np.stack([corners[before[index]], corners[index], corners[after[index]]], axis=1)
    )
    points = shapely.STRtree(shapely.points(corners))
    triangle, point = points.query(triangles, predicate="intersects")
    # Another ring that touches the very corner passes through its triangle; one that touches an end
    # of the cut cannot.
    own = (
        (point == index[triangle])
        | (corners[point] == corners[before[index[triangle]]]).all(axis=1)
        | (corners[point] == corners[after[index[triangle]]]).all(axis=1)
    )
    kept = chosen.copy()
    kept[index[triangle[~own]]] = False
    return kept
