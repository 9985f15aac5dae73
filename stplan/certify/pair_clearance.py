"""Least distance of two moving agents over all time, in closed form.

Between the knots of both curves the relative position is linear in time, so on every merged interval
the least distance is that of the origin to a segment. Nothing is sampled. This module shares no code with
the optimiser on purpose: it is what the optimiser's answers are judged by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inner, kernel
from stplan.problem.world_lines import WorldLines


@dataclass(frozen=True)
class NearestMoments:
    """The nearest moment of every pair asked for.

    Attributes:
        pairs: (P, 2) agents a < b.
        distance: (P,) m, inf where the two are never present together.
        instant: (P,) s.
        middle: (P, 2) m, halfway between the two then.
    """

    pairs: IntArray
    distance: FloatArray
    instant: FloatArray
    middle: FloatArray


def nearest_moments(lines: WorldLines, leaves: FloatArray, wanted: BoolArray) -> NearestMoments:
    """When and where the agents of every wanted pair are nearest to each other, in the order of agents.

    Args:
        leaves: (A,) until when each agent is present, at or after its last knot; it stands still
            after the last knot.
        wanted: (A, A), asked for a < b.
    """
    return nearest_moments_of(lines, leaves, np.argwhere(np.triu(wanted, 1)))


def nearest_moments_of(lines: WorldLines, leaves: FloatArray, pairs: IntArray) -> NearestMoments:
    """The same of `pairs` (P, 2) in their order."""
    count = len(pairs)
    found = NearestMoments(pairs, np.empty(count), np.empty(count), np.empty((count, 2)))
    _fill(
        lines.knots, lines.offsets, leaves, np.ascontiguousarray(pairs, dtype=np.int64),
        found.distance, found.instant, found.middle,
    )  # fmt: skip
    return found


@kernel
def _fill(
    knots: FloatArray,
    offsets: IntArray,
    leaves: FloatArray,
    pairs: IntArray,
    distance: FloatArray,
    instant: FloatArray,
    middle: FloatArray,
) -> None:
    for k in range(len(pairs)):
        a = pairs[k, 0]
        b = pairs[k, 1]
        distance[k], instant[k], middle[k, 0], middle[k, 1] = _least_distance(
            knots[offsets[a] : offsets[a + 1]],
            knots[offsets[b] : offsets[b + 1]],
            leaves[a],
            leaves[b],
        )


@inner
def _least_distance(
    first: FloatArray, second: FloatArray, first_leaves: float, second_leaves: float
) -> tuple[float, float, float, float]:
    """Least distance, when, and the point halfway between the two at that time."""
    begin = max(first[0, 2], second[0, 2])
    end = min(first_leaves, second_leaves)
    best = np.inf
    when = begin
    middle_x = np.nan
    middle_y = np.nan
    if end < begin:
        return best, when, middle_x, middle_y
    i = 0
    j = 0
    now = begin
    while True:
        while i < len(first) - 1 and first[i + 1, 2] <= now:
            i += 1
        while j < len(second) - 1 and second[j + 1, 2] <= now:
            j += 1
        until = end
        if i < len(first) - 1:
            until = min(until, first[i + 1, 2])
        if j < len(second) - 1:
            until = min(until, second[j + 1, 2])
        ax, ay = _position(first, i, now)
        bx, by = _position(second, j, now)
        cx, cy = _position(first, i, until)
        dx, dy = _position(second, j, until)
        # The relative position runs from (x, y) along (ux, uy) as the fraction goes from 0 to 1.
        x, y = ax - bx, ay - by
        ux, uy = cx - dx - x, cy - dy - y
        squared = ux * ux + uy * uy
        fraction = 0.0
        if squared > 0.0:
            fraction = min(max(-(x * ux + y * uy) / squared, 0.0), 1.0)
        gap = np.hypot(x + fraction * ux, y + fraction * uy)
        if gap < best:
            best = gap
            when = now + fraction * (until - now)
            middle_x = 0.5 * (ax + bx + fraction * (cx - ax + dx - bx))
            middle_y = 0.5 * (ay + by + fraction * (cy - ay + dy - by))
        if until >= end:
            return best, when, middle_x, middle_y
        now = until


@inner
def _position(curve: FloatArray, segment: int, time: float) -> tuple[float, float]:
    """Where an agent is at `time` s, on or after knot `segment`; at rest after its last knot."""
    if segment >= len(curve) - 1:
        return curve[-1, 0], curve[-1, 1]
    span = curve[segment + 1, 2] - curve[segment, 2]
    part = (time - curve[segment, 2]) / span
    return (
        curve[segment, 0] + part * (curve[segment + 1, 0] - curve[segment, 0]),
        curve[segment, 1] + part * (curve[segment + 1, 1] - curve[segment, 1]),
    )
