"""Compiled retiming: knots of even durations along clear curves, in (x, y, c t)."""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import TIME
from stplan.compiled import inlined, kernel
from stplan.geometry.allocation import new_flags, new_integer_rows, new_integers, new_number_rows
from stplan.seeding.shortcutting.rod_field import RodField, segment_clear

# Candidates lie this far apart in time, as a part of the mean duration.
SPACING = 0.25
# A segment shorter than this part of the mean may be replaced by the corner of its neighbours.
SHORT = 0.6


@kernel
def even_knots(
    field: RodField, agent: int, num_knots: int, shortest: float, longest: float
) -> bool:
    """Give a curve exactly `num_knots` knots of even durations, if that can be done clear.

    Knots are chosen among the candidates, at durations between `shortest` and `longest` times the
    mean, by dynamic programming on the sum of squared deviations from the mean; chords that are no
    piece of the old curve are asked for clearance. Knots on waypoints stay. Returns whether there
    was a way; without one the curve is left as it is. The index of the field is not told.
    """
    knots = field.knots[agent]
    mean = (knots[field.counts[agent] - 1, TIME] - knots[0, TIME]) / (num_knots - 1)
    points, leaves, reaches, fixed = _candidates(field, agent, mean)
    count = len(points)
    cost = new_number_rows(count, num_knots)
    previous = new_integer_rows(count, num_knots)
    reached = new_flags(count)
    for i in range(count):
        reached[i] = i == 0
        for k in range(num_knots):
            cost[i, k] = np.inf
    cost[0, 0] = 0.0
    for j in range(1, count):
        i = j - 1
        while i >= 0 and points[j, TIME] - points[i, TIME] <= longest * mean:
            duration = (points[j, TIME] - points[i, TIME]) / mean
            # On one segment of the old curve a chord is clear as it is.
            if (
                reached[i]
                and duration >= shortest
                and (reaches[j] <= leaves[i] or segment_clear(field, agent, points[i], points[j]))
            ):
                reached[j] = True
                # Numbers of knots that durations allow before and after candidate i.
                early = (points[i, TIME] - points[0, TIME]) / mean
                late = (points[count - 1, TIME] - points[i, TIME]) / mean
                least = max(early / longest, num_knots - 1 - late / shortest)
                most = min(early / shortest, num_knots - 1 - late / longest)
                for k in range(max(int(least) - 1, 0), min(int(most) + 2, num_knots - 1)):
                    total = cost[i, k] + (duration - 1.0) ** 2
                    if total < cost[j, k + 1]:
                        cost[j, k + 1] = total
                        previous[j, k + 1] = i
            if fixed[i]:
                break
            i -= 1
    if cost[count - 1, num_knots - 1] == np.inf:
        return False
    j = count - 1
    for k in range(num_knots - 1, -1, -1):
        for x in range(knots.shape[1]):
            knots[k, x] = points[j, x]
        field.pinned[agent, k] = fixed[j]
        if k > 0:
            j = previous[j, k]
    field.counts[agent] = num_knots
    return True


@inlined
def _candidates(
    field: RodField, agent: int, mean: float
) -> tuple[FloatArray, IntArray, IntArray, BoolArray]:
    """Places for knots, in order of time: the old ones, points between, corners cut short.

    Returns points (N, 3); the segments of the old curve that a point leaves and reaches (N,), so
    that a chord from i to j lies on the curve if reaches[j] <= leaves[i]; and waypoint flags (N,).
    """
    knots = field.knots[agent]
    count = field.counts[agent]
    parts = new_integers(count - 1)
    total = 1
    for i in range(count - 1):
        duration = knots[i + 1, TIME] - knots[i, TIME]
        parts[i] = max(int(np.rint(duration / (SPACING * mean))), 1)
        total += parts[i] + 3
    points = new_number_rows(total, 3)
    leaves = new_integers(total)
    reaches = new_integers(total)
    fixed = new_flags(total)
    at = 0
    for i in range(count - 1):
        short = knots[i + 1, TIME] - knots[i, TIME] < SHORT * mean
        corner = 0 < i < count - 2 and short
        for k in range(1 if corner else parts[i]):
            for x in range(knots.shape[1]):
                points[at, x] = knots[i, x] + (knots[i + 1, x] - knots[i, x]) * (k / parts[i])
            leaves[at] = i
            reaches[at] = i if k > 0 else i - 1
            fixed[at] = k == 0 and field.pinned[agent, i]
            at += 1
        if corner:
            _corners(knots, i, points, at)
            # Off the curve: no chord from or to them counts as clear unasked.
            for k in range(at, at + 3):
                leaves[k] = -1
                reaches[k] = count
                fixed[k] = False
            at += 3
    for x in range(knots.shape[1]):
        points[at, x] = knots[count - 1, x]
    leaves[at] = count - 1
    reaches[at] = count - 2
    fixed[at] = False
    return points[: at + 1], leaves, reaches, fixed


@inlined
def _corners(knots: FloatArray, i: int, points: FloatArray, at: int) -> None:
    """Three points from `at` on, half-way in time on segment i: its neighbours prolonged, and between."""
    middle = 0.5 * (knots[i, TIME] + knots[i + 1, TIME])
    before = (middle - knots[i - 1, TIME]) / (knots[i, TIME] - knots[i - 1, TIME])
    after = (middle - knots[i + 1, TIME]) / (knots[i + 2, TIME] - knots[i + 1, TIME])
    for x in range(knots.shape[1] - 1):
        points[at, x] = knots[i - 1, x] + before * (knots[i, x] - knots[i - 1, x])
        points[at + 1, x] = knots[i + 1, x] + after * (knots[i + 2, x] - knots[i + 1, x])
        points[at + 2, x] = 0.5 * (points[at, x] + points[at + 1, x])
    for k in range(3):
        points[at + k, TIME] = middle
