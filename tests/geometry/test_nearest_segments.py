"""What weighs in a least distance is found without comparing everything, and is the same."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.geometry.contacts import measure
from stplan.geometry.nearest_segments import near_minimum


@pytest.mark.parametrize("slack", [0.0, 0.5, 100.0])
def test_as_if_all_pairs_were_compared(slack: float) -> None:
    rng = np.random.default_rng(4)
    counts = np.array([21, 9, 30])
    ends = np.cumsum(counts + 1)
    positions = np.cumsum(rng.normal(size=(ends[-1], 3)), axis=0)
    # The second rod is far from the others: no reach would find it.
    positions[ends[0] : ends[1]] += 500.0
    first = np.setdiff1d(np.arange(ends[-1]), ends - 1)
    segments = np.column_stack([first, first + 1])
    begins = np.concatenate([[0], np.cumsum(counts)])
    pairs = [(0, 1), (0, 2), (1, 2)]
    ranges = np.array([[begins[a], begins[a + 1], begins[b], begins[b + 1]] for a, b in pairs])
    found, group = near_minimum(positions, segments, ranges, np.full(len(ranges), slack))
    for g, (a0, a1, b0, b1) in enumerate(ranges):
        grid = np.meshgrid(np.arange(a0, a1), np.arange(b0, b1), indexing="ij")
        every = np.column_stack([axis.ravel() for axis in grid])
        points = np.hstack([segments[every[:, 0]], segments[every[:, 1]]])
        distance = measure(positions, points).distance
        wanted = every[distance < distance.min() + slack]
        assert sorted(map(tuple, found[group == g])) == sorted(map(tuple, wanted))
