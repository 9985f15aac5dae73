"""When to be where along a way at one speed, among others who are known at every step of a grid of times.

In every step an agent stands or goes on by one point of its way. Which points can be reached after how many
steps is worked out step by step, so the first arrival after which it can stay for good is found, or that
there is none: once all others stand, waiting longer changes nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inner, kernel

# How a point was reached in a step: not at all, by standing, by going on, or both.
_STOOD, _WENT = 1, 2


@kernel
def timed_way(
    points: FloatArray, theirs: FloatArray, apart: FloatArray, latest: int
) -> tuple[int, IntArray]:
    """The earliest arrival at the end of a way: the step, and the point (arrival + 1,) at every step.

    Waits are as early on the way as can be.

    Args:
        points: (n + 1, 2) m, of which the agent passes one in a step at most.
        theirs: (B, K + 1, 2) m, where others are at every step from now on; they stay where they are last.
        apart: (B,) m, what is kept from each.
        latest: an arrival after so many steps is of no use.

    Returns:
        -1 and nothing where the end cannot be reached, or not for good.
    """
    last, end = theirs.shape[1] - 1, len(points) - 1
    nothing = np.empty(0, np.int64)
    if last == 0:
        # Nobody moves: one step more says so.
        theirs = np.concatenate((theirs, theirs), axis=1)
        last = 1
    free = _free_for_good(points[end], theirs, apart)
    if free < 0 or free > latest:
        return -1, nothing
    count = min(last + end, latest)
    how = np.zeros((count + 1, end + 1), np.int8)
    how[0, 0] = _STOOD
    low, high = 0, 0
    longest = 0.0
    for s in range(end):
        x, y = points[s + 1, 0] - points[s, 0], points[s + 1, 1] - points[s, 1]
        longest = max(longest, np.sqrt(x * x + y * y))
    near = np.empty(len(theirs), np.int64)
    arrival = -1
    for k in range(count + 1):
        if how[k, end] and k >= free:
            arrival = k
            break
        if k == count:
            break
        now, then = min(k, last), min(k + 1, last)
        num_near = _nearby(points[low : high + 1], theirs, now, then, apart, longest, near)
        first, final = -1, -1
        for s in range(low, high + 1):
            if not how[k, s]:
                continue
            if _clear(points, s, s, theirs, now, then, apart, near, num_near):
                how[k + 1, s] |= _STOOD
                first = s if first < 0 else first
                final = max(final, s)
            if s < end and _clear(points, s, s + 1, theirs, now, then, apart, near, num_near):
                how[k + 1, s + 1] |= _WENT
                first = s + 1 if first < 0 else first
                final = max(final, s + 1)
        if first < 0:
            break
        low, high = first, final
    if arrival < 0:
        return -1, nothing
    at = np.empty(arrival + 1, np.int64)
    at[arrival] = end
    for k in range(arrival, 0, -1):
        at[k - 1] = at[k] - 1 if how[k, at[k]] & _WENT else at[k]
    return arrival, at


@inner
def _free_for_good(point: FloatArray, theirs: FloatArray, apart: FloatArray) -> int:
    """From which step on a point is clear of all others; -1 if never."""
    last = theirs.shape[1] - 1
    free = 0
    for b in range(len(theirs)):
        x, y = theirs[b, last, 0] - point[0], theirs[b, last, 1] - point[1]
        if x * x + y * y <= apart[b] * apart[b]:
            return -1
        k = last
        while k > free:
            u, v = theirs[b, k - 1, 0] - point[0], theirs[b, k - 1, 1] - point[1]
            if _gap_squared(u, v, x, y) <= apart[b] * apart[b]:
                break
            x, y = u, v
            k -= 1
        free = max(free, k)
    return free


@inner
def _nearby(
    points: FloatArray,
    theirs: FloatArray,
    now: int,
    then: int,
    apart: FloatArray,
    longest: float,
    near: NDArray[np.int64],
) -> int:
    """Who may come near some `points` between two steps: how many, their indices in `near`."""
    low_x, high_x = points[:, 0].min() - longest, points[:, 0].max() + longest
    low_y, high_y = points[:, 1].min() - longest, points[:, 1].max() + longest
    count = 0
    for b in range(len(theirs)):
        reach = apart[b]
        if (
            max(theirs[b, now, 0], theirs[b, then, 0]) >= low_x - reach
            and min(theirs[b, now, 0], theirs[b, then, 0]) <= high_x + reach
            and max(theirs[b, now, 1], theirs[b, then, 1]) >= low_y - reach
            and min(theirs[b, now, 1], theirs[b, then, 1]) <= high_y + reach
        ):
            near[count] = b
            count += 1
    return count


@inner
def _clear(
    points: FloatArray,
    s: int,
    t: int,
    theirs: FloatArray,
    now: int,
    then: int,
    apart: FloatArray,
    near: NDArray[np.int64],
    num_near: int,
) -> bool:
    """Whether going from point s to point t between two steps is clear of those `near`."""
    for n in range(num_near):
        b = near[n]
        gap = _gap_squared(
            points[s, 0] - theirs[b, now, 0], points[s, 1] - theirs[b, now, 1],
            points[t, 0] - theirs[b, then, 0], points[t, 1] - theirs[b, then, 1],
        )  # fmt: skip
        if gap <= apart[b] * apart[b]:
            return False
    return True


@inner
def _gap_squared(x: float, y: float, u: float, v: float) -> float:
    """Least squared length of an offset that goes from (x, y) straight to (u, v)."""
    dx, dy = u - x, v - y
    squared = dx * dx + dy * dy
    share = 0.0
    if squared > 0.0:
        share = min(max(-(x * dx + y * dy) / squared, 0.0), 1.0)
    a, b = x + share * dx, y + share * dy
    return a * a + b * b
