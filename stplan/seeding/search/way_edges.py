"""Agents' own ways as vertices and edges of a graph, so that it misses none of them.

A way along arcs has many short pieces. Here they are drawn as few tangents as leave it clear, and ways that
run beside each other share vertices.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.deadline import heed

if TYPE_CHECKING:
    from stplan.world.free_space import FreeSpace

# Turns drawn as one corner, at most, the widest first.
WIDEST_TURNS = (math.pi / 4, math.pi / 8)
# Knots within this share of the spacing of a vertex of another way become that vertex.
SHARED = 0.15


class Track(NamedTuple):
    """A way for a graph: (n, 2) polylines from stop to stop, and the distance to walls they exceed; m."""

    legs: tuple[FloatArray, ...]
    clearance: float


def way_edges(
    free_space: FreeSpace, places: FloatArray, tracks: Sequence[Track], spacing: float
) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 2) of which the first are the `places`, and edges (m, 2) along all `tracks`.

    Their ends are among the places. Edges are about as long as `spacing` (m) at most; each exceeds the
    clearance of its track.
    """
    known = _Places(SHARED * spacing)
    known.add(places)
    edges = [np.empty((0, 2), dtype=np.int64)]
    for legs, clearance in tracks:
        for leg in legs:
            heed()
            knots = cut(mitred(free_space, leg, clearance), spacing)
            numbers = _entered(free_space, known, knots, clearance)
            edges.append(np.column_stack([numbers[:-1], numbers[1:]]))
    joined = np.vstack(edges)
    return known.points, joined[joined[:, 0] != joined[:, 1]]


def _entered(
    free_space: FreeSpace, known: _Places, knots: FloatArray, clearance: float
) -> IntArray:
    """(n,) which of the `known` places `knots` (n, 2) are, those that are new among them by then."""
    near, apart = known.nearest(knots)
    shared = np.isfinite(apart)
    # Ends are places, to the last bit.
    shared[[0, -1]] = apart[[0, -1]] == 0.0
    moved = np.where(shared[:, None], known.points[near], knots)
    free = free_space.segment_clearance(moved[:-1], moved[1:]) > clearance
    if not free.all():
        shared = apart == 0.0
        moved = knots
    near[~shared] = known.add(moved[~shared])
    return near


class _Places:
    """A growing number of points, and which of them lies nearest to another one, within a `reach` in m."""

    def __init__(self, reach: float) -> None:
        self._reach = reach
        # A bit more than the reach, so that rounding hides nobody from the next cell.
        self._size = 1.001 * reach
        self._cells: dict[tuple[int, int], list[int]] = {}
        self._points = np.empty((256, 2))
        self._count = 0

    @property
    def points(self) -> FloatArray:
        """(n, 2) all of them, m."""
        return self._points[: self._count]

    def add(self, points: FloatArray) -> IntArray:
        """Numbers (k,) of `points` (k, 2) from now on."""
        first, self._count = self._count, self._count + len(points)
        while len(self._points) < self._count:
            self._points = np.vstack([self._points, np.empty_like(self._points)])
        self._points[first : self._count] = points
        numbers = np.arange(first, self._count)
        for cell, number in zip(self._cells_of(points), numbers.tolist(), strict=True):
            self._cells.setdefault(cell, []).append(number)
        return numbers

    def nearest(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Number of the one nearest to each of `points` (k, 2), the first of equals, and its distance, m.

        -1 and inf where none is within reach.
        """
        near, apart = np.full(len(points), -1), np.full(len(points), np.inf)
        for k, (i, j) in enumerate(self._cells_of(points)):
            around = [(i + x, j + y) for x in (-1, 0, 1) for y in (-1, 0, 1)]
            others = sorted(n for cell in around for n in self._cells.get(cell, ()))
            if others:
                step = points[k] - self._points[others]
                far = np.hypot(step[:, 0], step[:, 1])
                best = int(far.argmin())
                if far[best] <= self._reach:
                    near[k], apart[k] = others[best], far[best]
        return near, apart

    def _cells_of(self, points: FloatArray) -> list[tuple[int, int]]:
        return [(i, j) for i, j in np.floor(points / self._size).astype(np.int64).tolist()]


def mitred(free_space: FreeSpace, leg: FloatArray, clearance: float) -> FloatArray:
    """`leg` (n, 2) with fewer knots, where that stays further than `clearance` (m) from the walls."""
    for widest in WIDEST_TURNS:
        simpler = _with_corners(leg, widest)
        if len(simpler) == len(leg):
            break
        if (free_space.segment_clearance(simpler[:-1], simpler[1:]) > clearance).all():
            return simpler
    return leg


def _with_corners(leg: FloatArray, widest: float) -> FloatArray:
    """`leg`, consecutive turns to one side of up to `widest` (rad) together drawn as one corner."""
    step = np.diff(leg, axis=0)
    cross = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
    turns = np.arctan2(cross, (step[:-1] * step[1:]).sum(axis=1))
    knots = [leg[0]]
    first = 0
    while first < len(turns):
        last, total = first, turns[first]
        while (
            last + 1 < len(turns)
            and turns[last + 1] * turns[first] > 0
            and abs(total + turns[last + 1]) <= widest
        ):
            last += 1
            total += turns[last]
        # Knot k + 1 turns by turns[k] between steps k and k + 1.
        knots.append(
            leg[first + 1]
            if last == first
            else _crossing(leg[first + 1], step[first], leg[last + 1], step[last + 1])
        )
        first = last + 1
    return np.vstack([*knots, leg[-1]])


def _crossing(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
    """Where the line from `p` along `u` meets the one through `q` along `v`."""
    across = u[0] * v[1] - u[1] * v[0]
    share = ((q[0] - p[0]) * v[1] - (q[1] - p[1]) * v[0]) / across
    return np.asarray(p + share * u)


def cut(way: FloatArray, longest: float) -> FloatArray:
    """`way` (n, 2) with knots at most `longest` (m) apart; its own are kept to the last bit."""
    step = np.diff(way, axis=0)
    counts = np.maximum(np.ceil(np.hypot(step[:, 0], step[:, 1]) / longest), 1.0).astype(np.int64)
    piece = np.repeat(np.arange(len(step)), counts)
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    points = way[piece] + step[piece] * (number / counts[piece])[:, None]
    return np.vstack([points, way[-1:]])
