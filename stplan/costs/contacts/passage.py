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

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.rod_neighbours import near_segments
from stplan.geometry.segments import Point, squared_distance
from stplan.geometry.wall_distances import squared_edge_distance

# Share of the distance to keep that is kept wherever a step is measured, half of it everywhere else: the
# less, the more measurements in the worst case.
KEPT_ON_THE_WAY = 0.1
HALF = 0.5
# A pair that takes more measurements than this is taken to touch.
MOST_MEASUREMENTS = 1000


def rods_stay_apart(
    start: FloatArray,
    end: FloatArray,
    segments: IntArray,
    agents: IntArray,
    collides: BoolArray,
    distance: FloatArray,
) -> bool:
    """Whether no two rods pass through each other while positions move straight from `start` to `end`.

    Args:
        start, end: (P, 3) in (x, y, c t), m; the rods are further apart than `distance` at both.
        segments: (S, 2) indices of end points.
        agents: (S,) owner of every segment.
        collides: (A, A) which pairs of agents are asked for.
        distance: (A, A) what they keep, m.
    """
    motion = np.sqrt(((end - start) ** 2).sum(axis=1))
    furthest = float(motion.max(initial=0.0))
    if 2.0 * furthest <= (1.0 - KEPT_ON_THE_WAY) * float(distance[collides].min(initial=np.inf)):
        return True
    own = np.zeros(len(distance))
    np.maximum.at(own, agents, motion[segments].max(axis=1))
    reach = own[:, None] + own[None, :] + KEPT_ON_THE_WAY * distance
    # Whoever starts further apart than both may move has nothing to fear.
    moving = collides & (reach > distance)
    pairs = near_segments(start, segments, agents, moving, reach)
    kept = KEPT_ON_THE_WAY * distance[agents[pairs[:, 0]], agents[pairs[:, 1]]]
    return _pairs_stay_apart(start, end - start, segments, pairs, kept)


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
def _pairs_stay_apart(
    start: FloatArray, step: FloatArray, segments: IntArray, pairs: IntArray, kept: FloatArray
) -> bool:
    for k in range(len(pairs)):
        p0, p1 = segments[pairs[k, 0], 0], segments[pairs[k, 0], 1]
        q0, q1 = segments[pairs[k, 1], 0], segments[pairs[k, 1], 1]
        squared = 0.0
        for i in (p0, p1):
            for j in (q0, q1):
                own = 0.0
                for x in range(3):
                    own += (step[i, x] - step[j, x]) ** 2
                squared = max(squared, own)
        motion = np.sqrt(squared)
        passed = 0.0
        for measured in range(MOST_MEASUREMENTS + 1):
            gap = np.sqrt(
                squared_distance(
                    _on_the_way(start, step, p0, passed), _on_the_way(start, step, p1, passed),
                    _on_the_way(start, step, q0, passed), _on_the_way(start, step, q1, passed),
                )
            )  # fmt: skip
            if gap <= kept[k] or measured == MOST_MEASUREMENTS:
                return False
            room = gap - HALF * kept[k]
            if room >= (1.0 - passed) * motion:
                break
            passed += room / motion
    return True


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
        passed = 0.0
        for measured in range(MOST_MEASUREMENTS + 1):
            gap = np.sqrt(
                squared_edge_distance(
                    _on_the_plane_way(first, first_step, s, passed),
                    _on_the_plane_way(second, second_step, s, passed),
                    edges, pairs[k, 1],
                )
            )  # fmt: skip
            if gap <= kept[s] or measured == MOST_MEASUREMENTS:
                return False
            room = gap - HALF * kept[s]
            if room >= (1.0 - passed) * motion[s]:
                break
            passed += room / motion[s]
    return True
