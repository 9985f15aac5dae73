"""Bounds of variables and linear constraints: what a plan must keep whatever it costs.

Start, goal, waypoints and prescribed paths are fixed by equal bounds and T^max is a bound. That time runs on
is part of the objective's domain: the regularity cost rises without bound as a duration goes to zero. Where
no such cost stands guard (a weight of 0, a dwell) a least t_{i+1} - t_i is a linear constraint with a
constant Jacobian, as is t_i = t_j of the knots at which a pair meets. Constraints for all segments would
double the size of the linear systems. Ends that may move in a place are held there by half-planes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.problem.layout import KnotLayout

# What solvers take for no bound.
UNBOUNDED = 2e19


@dataclass(frozen=True)
class HalfPlanes:
    """Linear constraints on the places of knots: least <= normal . (x, y) <= greatest.

    Attributes:
        knots: (H,).
        normals: (H, 2), of length 1.
        least, greatest: (H,) m.
    """

    knots: IntArray
    normals: FloatArray
    least: FloatArray
    greatest: FloatArray

    @staticmethod
    def none() -> HalfPlanes:
        """No constraint."""
        return HalfPlanes(np.empty(0, np.int64), np.empty((0, 2)), np.empty(0), np.empty(0))

    def chosen(self, which: BoolArray) -> HalfPlanes:
        """Those that are True in `which` (H,)."""
        return HalfPlanes(
            self.knots[which], self.normals[which], self.least[which], self.greatest[which]
        )


@dataclass(frozen=True)
class Constraints:
    """What the knots of a layout must keep.

    Attributes:
        lower, upper: (M, 3) bounds of the knots, equal where a variable is fixed.
        least_duration: (S,) smallest t_{i+1} - t_i of every segment, s.
        guarded: (G,) segments whose least duration takes a constraint of its own.
        links: (L, 2) knots of one time.
        greatest_share: (S,) largest part of the whole duration that a segment may last, inf for any.
        planes: what holds places of knots that bounds alone cannot hold.
    """

    lower: FloatArray
    upper: FloatArray
    least_duration: FloatArray
    guarded: IntArray
    links: IntArray
    greatest_share: FloatArray
    planes: HalfPlanes = field(default_factory=HalfPlanes.none)

    def admits(self, layout: KnotLayout, knots: FloatArray) -> bool:
        """Whether knots (M, 3) are finite, with time running on: asked before terms divide by it."""
        start = layout.segment
        duration = knots[start + 1, 2] - knots[start, 2]
        # Half of it: solvers keep linear constraints to a tolerance.
        kept: BoolArray = duration > 0.5 * self.least_duration
        return bool(np.isfinite(knots).all() and kept.all())


@dataclass(frozen=True)
class LinearRows:
    """Linear functions of the flat knots x, with the least and greatest value each may take.

    Attributes:
        rows, columns, values: (N,) entries of the constant Jacobian.
        least, greatest: (C,) s, of half-planes m.
    """

    rows: IntArray
    columns: IntArray
    values: FloatArray
    least: FloatArray
    greatest: FloatArray

    def at(self, x: FloatArray) -> FloatArray:
        """(C,) values at flat knots (3 M,), s."""
        weighed = self.values * x[self.columns]
        return np.bincount(self.rows, weighed, len(self.least)).astype(np.float64)


def linear_rows(layout: KnotLayout, constraints: Constraints) -> LinearRows:
    """The linear constraints, in this order.

    t_{i+1} - t_i of guarded segments, t_j - t_i of links, what limited durations leave of their shares, all
    in s; and places of knots across half-planes, m.
    """
    timed, planes = _timed_rows(layout, constraints), constraints.planes
    if not len(planes.knots):
        return timed
    row, axis = np.nonzero(planes.normals)
    return LinearRows(
        np.concatenate([timed.rows, len(timed.least) + row]),
        np.concatenate([timed.columns, 3 * planes.knots[row] + axis]),
        np.concatenate([timed.values, planes.normals[row, axis]]),
        np.concatenate([timed.least, planes.least]),
        np.concatenate([timed.greatest, planes.greatest]),
    )


def _timed_rows(layout: KnotLayout, constraints: Constraints) -> LinearRows:
    segment, links = layout.segment, constraints.links
    start = segment[constraints.guarded]
    even = np.flatnonzero(np.isfinite(constraints.greatest_share))
    agent, share = layout.agent_of_segment[even], constraints.greatest_share[even]
    head = np.concatenate([start, links[:, 0], segment[even] + 1, layout.first[agent]])
    tail = np.concatenate([start + 1, links[:, 1], segment[even], layout.last[agent]])
    num_plain = len(start) + len(links)
    row = np.concatenate([np.arange(num_plain + len(even)), num_plain + np.arange(len(even))])
    weight = np.concatenate([np.ones(num_plain + len(even)), share])
    columns = np.column_stack([3 * head + 2, 3 * tail + 2]).ravel()
    # A segment at an end of its curve has an entry twice: they are added.
    size = 3 * layout.num_knots
    codes, place = np.unique(np.repeat(row, 2) * size + columns, return_inverse=True)
    values = np.bincount(place, np.column_stack([-weight, weight]).ravel(), len(codes))
    rows, columns = np.divmod(codes, size)
    none, same = np.full(len(start), UNBOUNDED), np.zeros(len(links))
    return LinearRows(
        rows,
        columns,
        values.astype(np.float64),
        least=np.concatenate(
            [constraints.least_duration[constraints.guarded], same, np.zeros(len(even))]
        ),
        greatest=np.concatenate([none, same, np.full(len(even), UNBOUNDED)]),
    )
