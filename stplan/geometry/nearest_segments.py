"""Which segments of two rods weigh in their least distance, however far apart the rods are.

A broad phase with a reach finds nothing where friends are far from each other. Here runs of segments
have bounding boxes, and pairs of runs whose boxes are further apart than the least distance found so
far are passed over, so most segments are never compared.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inner, kernel
from stplan.geometry.allocation import new_integer_rows, new_numbers
from stplan.geometry.growable import with_room
from stplan.geometry.segments import closest_of_segments

# Segments in a run.
RUN = 8


def near_minimum(
    positions: FloatArray, segments: IntArray, ranges: IntArray, slack: FloatArray
) -> tuple[IntArray, IntArray]:
    """Pairs of segments hardly further apart than the nearest ones of their two rods.

    Args:
        positions: (P, 3) points in (x, y, c t), m.
        segments: (S, 2) indices of end points.
        ranges: (G, 4) of every pair of rods: segments ``[0]:[1]`` of one, ``[2]:[3]`` of the other.
        slack: (G,) how much further apart than the nearest pair, m.

    Returns:
        (N, 2) segments of one and the other rod, and (N,) the pair of rods, in the order of `ranges`.
    """
    found = _near_minimum(positions, segments, ranges, slack)
    return found[:, :2].copy(), found[:, 2].copy()


@kernel
def _near_minimum(
    positions: FloatArray, segments: IntArray, ranges: IntArray, slack: FloatArray
) -> IntArray:
    """(N, 3) segment of one rod, segment of the other, pair of rods."""
    found = new_integer_rows(8 * len(ranges) + 64, 3)
    count = 0
    for g in range(len(ranges)):
        a0, a1, b0, b1 = ranges[g, 0], ranges[g, 1], ranges[g, 2], ranges[g, 3]
        rows = (a1 - a0 + RUN - 1) // RUN
        columns = (b1 - b0 + RUN - 1) // RUN
        bound = new_numbers(rows * columns)
        nearest = 0
        for r in range(rows):
            for c in range(columns):
                place = r * columns + c
                bound[place] = _box_distance(
                    positions, segments, a0 + r * RUN, min(a0 + (r + 1) * RUN, a1),
                    b0 + c * RUN, min(b0 + (c + 1) * RUN, b1),
                )  # fmt: skip
                if bound[place] < bound[nearest]:
                    nearest = place
        least = np.inf
        # The pair of runs with the nearest boxes first: it rules out most others.
        for step in range(-1, len(bound)):
            place = nearest if step < 0 else step
            if bound[place] >= least:
                continue
            r, c = place // columns, place % columns
            for i in range(a0 + r * RUN, min(a0 + (r + 1) * RUN, a1)):
                for j in range(b0 + c * RUN, min(b0 + (c + 1) * RUN, b1)):
                    least = min(least, _distance(positions, segments, i, j))
        for place in range(len(bound)):
            if bound[place] >= least + slack[g]:
                continue
            r, c = place // columns, place % columns
            found = with_room(found, count + RUN * RUN)
            for i in range(a0 + r * RUN, min(a0 + (r + 1) * RUN, a1)):
                for j in range(b0 + c * RUN, min(b0 + (c + 1) * RUN, b1)):
                    if _distance(positions, segments, i, j) < least + slack[g]:
                        found[count, 0] = i
                        found[count, 1] = j
                        found[count, 2] = g
                        count += 1
    return found[:count]


@inner
def _distance(positions: FloatArray, segments: IntArray, i: int, j: int) -> float:
    """Distance of segments i and j, m."""
    return np.sqrt(closest_of_segments(positions, segments, i, j)[2])


@inner
def _box_distance(
    positions: FloatArray, segments: IntArray, a0: int, a1: int, b0: int, b1: int
) -> float:
    """Distance of the bounding boxes of segments a0:a1 and b0:b1, m."""
    squared = 0.0
    for x in range(positions.shape[1]):
        low_a = high_a = positions[segments[a0, 0], x]
        for i in range(a0, a1):
            for end in range(2):
                low_a = min(low_a, positions[segments[i, end], x])
                high_a = max(high_a, positions[segments[i, end], x])
        low_b = high_b = positions[segments[b0, 0], x]
        for j in range(b0, b1):
            for end in range(2):
                low_b = min(low_b, positions[segments[j, end], x])
                high_b = max(high_b, positions[segments[j, end], x])
        gap = max(0.0, low_a - high_b, low_b - high_a)
        squared += gap * gap
    return np.sqrt(squared)
