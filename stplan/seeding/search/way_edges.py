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
    vertices = places
    edges = [np.empty((0, 2), dtype=np.int64)]
    for legs, clearance in tracks:
        for leg in legs:
            heed()
            knots = cut(mitred(free_space, leg, clearance), spacing)
            vertices, numbers = _entered(free_space, vertices, knots, clearance, spacing)
            edges.append(np.column_stack([numbers[:-1], numbers[1:]]))
    joined = np.vstack(edges)
    return vertices, joined[joined[:, 0] != joined[:, 1]]


def _entered(
    free_space: FreeSpace, vertices: FloatArray, knots: FloatArray, clearance: float, spacing: float
) -> tuple[FloatArray, IntArray]:
    """`vertices` with those of `knots` (n, 2) that are new, and (n,) which vertices they are."""
    step = knots[:, None] - vertices[None]
    apart = np.hypot(step[..., 0], step[..., 1])
    near = apart.argmin(axis=1)
    shared = apart[np.arange(len(knots)), near] <= SHARED * spacing
    # Ends are places, to the last bit.
    shared[[0, -1]] = apart[[0, -1], near[[0, -1]]] == 0.0
    moved = np.where(shared[:, None], vertices[near], knots)
    free = free_space.segment_clearance(moved[:-1], moved[1:]) > clearance
    if not free.all():
        shared = apart[np.arange(len(knots)), near] == 0.0
        moved = knots
    new = np.flatnonzero(~shared)
    numbers = near.astype(np.int64)
    numbers[new] = len(vertices) + np.arange(len(new))
    return np.vstack([vertices, moved[new]]), numbers


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
