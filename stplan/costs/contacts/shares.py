"""What one contact weighs in a sum over contacts, so that more knots make no greater sum."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.problem.layout import KnotLayout
from stplan.problem.rods import Rods

# n_0: of curves with no more segments than these every contact counts in full. Seeds get about as many.
REFERENCE_SEGMENTS = 30


def segment_shares(num_segments: IntArray) -> FloatArray:
    """(A,) weights of one of n segments of a curve in sums over contacts, min(1, n_0 / n).

    Where two curves come near each other, twice as many segments of both make four times as many
    contacts. With the product of both weights the sum tends to an integral over both curves instead.
    """
    return np.minimum(1.0, REFERENCE_SEGMENTS / np.maximum(num_segments, 1))


def rod_shares(rods: Rods, num_knots: int) -> FloatArray:
    """(P,) what a segment of a rod weighs, by the position it ends at; what stands on a goal weighs 1."""
    own = rods.num_curve_segments
    shares = np.ones(num_knots + len(rods.fixed_points))
    agents = rods.agents[:own]
    shares[rods.segments[:own, 1]] = segment_shares(rods.num_segments)[agents]
    return shares


def knot_shares(layout: KnotLayout, num_corners: int) -> FloatArray:
    """(M + B,) what knots weigh at walls, and 1 for the corners behind them."""
    own = segment_shares(layout.num_segments)[layout.agent_of_knot]
    return np.append(own, np.ones(num_corners))
