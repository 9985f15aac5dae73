"""Whether anything is passed through on the straight way from one iterate to the next.

Between two iterates every knot moves along a straight line, so segments sweep. Both ends of the step are
clear, but a thin rod may have jumped through another on the way, and with that left the homotopy class of
its seed. Here that is ruled out, conservatively: at every moment of the step the bare curves keep at least a
share of the distance that they have to keep at its ends.

The distance D of two segments changes no faster than the greatest relative motion L of an end of one and an
end of the other over the whole step, for points of segments are convex combinations of their ends. So after D
has been measured at one moment nothing can meet for another D / L of the step, and pairs with D > L need not
be looked at again at all. In this way a step is walked through in few exact measurements (conservative
advancement), and only by those whose motion exceeds their distance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import TIME
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.segments import Point, squared_distance
from stplan.geometry.wall_distances import squared_edge_distance
from stplan.problem.rods import Rods

# Share of the distance to keep that is kept wherever a step is measured, half of it everywhere else: the
# less, the more measurements in the worst case.
KEPT_ON_THE_WAY = 0.1
HALF = 0.5
# A pair that takes more measurements than this is taken to touch.
MOST_MEASUREMENTS = 1000


class _Sweep(NamedTuple):
    """S segments on their way, in (x, y, c t), m.

    Attributes:
        start, step: (P, 3) positions before, and what they move.
        segments: (S, 2) their ends.
        motion: (S,) how far an end moves at most.
        low, high: (2, S, 3) bounding boxes before and after.
    """

    start: FloatArray
    step: FloatArray
    segments: IntArray
    motion: FloatArray
    low: FloatArray
    high: FloatArray


class _Owned(NamedTuple):
    """Which segments are whose: a's are begins[a]:begins[a + 1], in the order of time, and tails[a], -1
    where it has none; furthest[a] is how far an end of them moves at most."""

    begins: IntArray
    tails: IntArray
    furthest: FloatArray


def rods_stay_apart(
    rods: Rods, start: FloatArray, end: FloatArray, collides: BoolArray, distance: FloatArray
) -> bool:
    """Whether no two rods pass through each other while knots move straight from `start` to `end`.

    Args:
        start, end: (M, 3); the rods are further apart than `distance` at both.
        collides: (A, A) which pairs of agents are asked for.
        distance: (A, A) what they keep, m.
    """
    before = rods.positions(start)
    step = rods.positions(end) - before
    least = float(distance[collides].min(initial=np.inf))
    if 2.0 * _furthest(step) <= (1.0 - KEPT_ON_THE_WAY) * least:
        return True
    own = rods.agents[: rods.num_curve_segments]
    tails = np.full(len(distance), -1)
    tails[rods.agents[len(own) :]] = np.arange(len(own), len(rods.segments))
    begins = np.searchsorted(own, np.arange(len(distance) + 1)).astype(np.int64)
    boxes = np.empty((2, 2, len(rods.segments), step.shape[1]))
    moved, furthest = np.zeros(len(rods.segments)), np.zeros(len(distance))
    _bound(before, step, rods.segments, rods.agents, boxes, moved, furthest)
    return _rods_stay_apart(
        _Sweep(before, step, rods.segments, moved, boxes[0], boxes[1]),
        _Owned(begins, tails, furthest),
        collides,
        distance,
    )


def walls_stay_clear(
    starts: FloatArray,
    ends: FloatArray,
    boundary: BoundaryGrid,
    radii: FloatArray,
) -> bool:
    """Whether no segment passes through the boundary while its ends move straight.

    Args:
        starts: (S, 2, 2) both ends of every segment in the plane before, m; further than its radius from
            the boundary.
        ends: (S, 2, 2) the same after.
        boundary: its edges.
        radii: (S,) what they keep, m.
    """
    motion = np.sqrt(((ends - starts) ** 2).sum(axis=2)).max(axis=1, initial=0.0)
    far = np.flatnonzero(motion > (1.0 - KEPT_ON_THE_WAY) * radii)
    if not len(far):
        return True
    first, second = (np.ascontiguousarray(starts[far, k]) for k in (0, 1))
    kept = KEPT_ON_THE_WAY * radii[far]
    pairs = boundary.near(first, second, motion[far] + kept)
    return _segments_stay_clear(
        first, second, np.ascontiguousarray(ends[far, 0]) - first,
        np.ascontiguousarray(ends[far, 1]) - second, motion[far], kept, pairs,
        boundary.edges,
    )  # fmt: skip


@inlined
def _on_the_way(start: FloatArray, step: FloatArray, index: int, passed: float) -> Point:
    """A position in (x, y, c t) after a part of the step."""
    return (
        start[index, 0] + passed * step[index, 0],
        start[index, 1] + passed * step[index, 1],
        start[index, 2] + passed * step[index, 2],
    )


@inlined
def _on_the_plane_way(start: FloatArray, step: FloatArray, index: int, passed: float) -> Point:
    """A position in the plane after a part of the step."""
    return start[index, 0] + passed * step[index, 0], start[index, 1] + passed * step[index, 1]


@kernel
def _furthest(step: FloatArray) -> float:
    """How far anybody moves, m."""
    squared = 0.0
    for k in range(len(step)):
        own = 0.0
        for x in range(step.shape[1]):
            own += step[k, x] * step[k, x]
        squared = max(squared, own)
    return np.sqrt(squared)


@kernel
def _bound(
    start: FloatArray,
    step: FloatArray,
    segments: IntArray,
    agents: IntArray,
    boxes: FloatArray,
    motion: FloatArray,
    furthest: FloatArray,
) -> None:
    """Fill in the boxes (low and high, before and after, by segment and axis), the motion of segments (S,)
    and of agents (A,)."""
    for k in range(len(segments)):
        p, q = segments[k, 0], segments[k, 1]
        own, other = 0.0, 0.0
        for x in range(step.shape[1]):
            for after in range(2):
                a, b = start[p, x] + after * step[p, x], start[q, x] + after * step[q, x]
                boxes[0, after, k, x] = min(a, b)
                boxes[1, after, k, x] = max(a, b)
            own += step[p, x] * step[p, x]
            other += step[q, x] * step[q, x]
        motion[k] = np.sqrt(max(own, other))
        furthest[agents[k]] = max(furthest[agents[k]], motion[k])


@kernel
def _rods_stay_apart(
    sweep: _Sweep, owned: _Owned, collides: BoolArray, distance: FloatArray
) -> bool:
    for a in range(len(distance)):
        for b in range(a + 1, len(distance)):
            kept = KEPT_ON_THE_WAY * distance[a, b]
            # Whoever starts further apart than both may move has nothing to fear.
            if (
                collides[a, b]
                and owned.furthest[a] + owned.furthest[b] > distance[a, b] - kept
                and not _both_stay_apart(sweep, owned, a, b, distance[a, b], kept)
            ):
                return False
    return True


@inner
def _both_stay_apart(
    sweep: _Sweep, owned: _Owned, a: int, b: int, distance: float, kept: float
) -> bool:
    """Whether agents a and b, walked along in time together, pass through each other nowhere."""
    low, high = sweep.low, sweep.high
    reach = owned.furthest[a] + owned.furthest[b] + kept
    begin, past = owned.begins[b], owned.begins[b + 1]
    tail = owned.tails[b]
    for k in range(owned.begins[a], owned.begins[a + 1] + 1):
        # Its tail comes last.
        i = k if k < owned.begins[a + 1] else owned.tails[a]
        if i < 0 or sweep.motion[i] + owned.furthest[b] <= distance - kept:
            continue
        while begin < past and high[0, begin, TIME] < low[0, i, TIME] - reach:
            begin += 1
        for m in range(begin, past + 1):
            j = m if m < past else tail
            if m < past and low[0, m, TIME] > high[0, i, TIME] + reach:
                j = tail
            if (
                j >= 0
                and not _stays_ahead(low, high, i, j, kept)
                and not _pair_stays_apart(sweep, i, j, kept)
            ):
                return False
            if j == tail:
                break
    return True


@inlined
def _stays_ahead(low: FloatArray, high: FloatArray, i: int, j: int, kept: float) -> bool:
    """Whether one of two segments is ahead of the other along an axis, before and after the step.

    As ends move linearly, it then is so all the time. The last axis, time, tells most apart.
    """
    ahead = False
    for y in range(low.shape[2]):
        x = low.shape[2] - 1 - y
        if low[0, i, x] - high[0, j, x] > kept:
            ahead = low[1, i, x] - high[1, j, x] > kept
        elif low[0, j, x] - high[0, i, x] > kept:
            ahead = low[1, j, x] - high[1, i, x] > kept
        if ahead:
            break
    return ahead


@inner
def _pair_stays_apart(sweep: _Sweep, i: int, j: int, kept: float) -> bool:
    """Whether two segments keep apart, by conservative advancement."""
    start, step = sweep.start, sweep.step
    p0, p1 = sweep.segments[i, 0], sweep.segments[i, 1]
    q0, q1 = sweep.segments[j, 0], sweep.segments[j, 1]
    squared = 0.0
    for p in (p0, p1):
        for q in (q0, q1):
            own = 0.0
            for x in range(start.shape[1]):
                own += (step[p, x] - step[q, x]) ** 2
            squared = max(squared, own)
    motion = np.sqrt(squared)
    passed = 0.0
    for _ in range(MOST_MEASUREMENTS):
        gap = np.sqrt(
            squared_distance(
                _on_the_way(start, step, p0, passed), _on_the_way(start, step, p1, passed),
                _on_the_way(start, step, q0, passed), _on_the_way(start, step, q1, passed),
            )
        )  # fmt: skip
        if gap <= kept:
            return False
        room = gap - HALF * kept
        if room >= (1.0 - passed) * motion:
            return True
        passed += room / motion
    return False


@kernel
def _segments_stay_clear(
    first: FloatArray,
    second: FloatArray,
    first_step: FloatArray,
    second_step: FloatArray,
    motion: FloatArray,
    kept: FloatArray,
    pairs: IntArray,
    edges: FloatArray,
) -> bool:
    for k in range(len(pairs)):
        s = pairs[k, 0]
        clear = False
        passed = 0.0
        for _ in range(MOST_MEASUREMENTS):
            gap = np.sqrt(
                squared_edge_distance(
                    _on_the_plane_way(first, first_step, s, passed),
                    _on_the_plane_way(second, second_step, s, passed),
                    edges, pairs[k, 1],
                )
            )  # fmt: skip
            if gap <= kept[s]:
                break
            room = gap - HALF * kept[s]
            clear = room >= (1.0 - passed) * motion[s]
            if clear:
                break
            passed += room / motion[s]
        if not clear:
            return False
    return True
