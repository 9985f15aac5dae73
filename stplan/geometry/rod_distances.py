"""Compiled distances of rods; exact between knots."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.axes import TIME
from stplan.compiled import kernel
from stplan.geometry.allocation import new_number_rows, new_numbers
from stplan.geometry.segments import (
    closest_of_segments,
    closest_parameters,
    space_time_point,
    squared_distance,
)


@kernel
def rod_distance(first: FloatArray, second: FloatArray, limit: float) -> float:
    """Distance of two rods (n, 3), (m, 3) in (x, y, c t) with rising time, `limit` if larger; m.

    Both are walked once in time: only segments whose times, and boxes in the plane, come within the limit are
    compared.
    """
    least = limit * limit
    # Rounding must not hide anybody who is just within it.
    reach = limit * (1.0 + 1e-9)
    begin = 0
    for i in range(len(first) - 1):
        left, right = min(first[i, 0], first[i + 1, 0]), max(first[i, 0], first[i + 1, 0])
        low, high = min(first[i, 1], first[i + 1, 1]), max(first[i, 1], first[i + 1, 1])
        while begin < len(second) - 2 and second[begin + 1, TIME] < first[i, TIME] - limit:
            begin += 1
        j = begin
        while j < len(second) - 1 and second[j, TIME] <= first[i + 1, TIME] + limit:
            apart = max(
                min(second[j, 0], second[j + 1, 0]) - right,
                left - max(second[j, 0], second[j + 1, 0]),
                min(second[j, 1], second[j + 1, 1]) - high,
                low - max(second[j, 1], second[j + 1, 1]),
            )
            if apart <= reach:
                gap = squared_distance(
                    space_time_point(first, i), space_time_point(first, i + 1),
                    space_time_point(second, j), space_time_point(second, j + 1),
                )  # fmt: skip
                least = min(least, gap)
            j += 1
    return np.sqrt(least)


@kernel
def closest_points(first: FloatArray, second: FloatArray) -> FloatArray:
    """(2, 3) closest points of two rods (n, 3), (m, 3) in (x, y, c t), one of each; m."""
    result = new_number_rows(2, 3)
    least = np.inf
    for i in range(len(first) - 1):
        for j in range(len(second) - 1):
            s, t, squared = closest_parameters(
                space_time_point(first, i), space_time_point(first, i + 1),
                space_time_point(second, j), space_time_point(second, j + 1),
            )  # fmt: skip
            if squared < least:
                least = squared
                for x in range(3):
                    result[0, x] = first[i, x] + s * (first[i + 1, x] - first[i, x])
                    result[1, x] = second[j, x] + t * (second[j + 1, x] - second[j, x])
    return result


@kernel
def segment_distances(positions: FloatArray, segments: IntArray, pairs: IntArray) -> FloatArray:
    """(N,) distances of the pairs (N, 2) of segments (S, 2) between positions (P, 3); m."""
    result = new_numbers(len(pairs))
    for k in range(len(pairs)):
        gap = closest_of_segments(positions, segments, pairs[k, 0], pairs[k, 1])[2]
        result[k] = np.sqrt(gap)
    return result
