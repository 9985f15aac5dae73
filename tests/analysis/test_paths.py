"""Lengths, speeds and places of single curves."""

from __future__ import annotations

import numpy as np

from stplan.analysis.paths import path_length, place_at, positions, segment_speeds
from stplan.problem.world_lines import WorldLines

CURVE = np.array([[0.0, 0.0, 1.0], [3.0, 4.0, 3.0], [3.0, 4.0, 5.0], [3.0, 5.0, 9.0]])


def test_lengths_and_speeds():
    assert path_length(CURVE) == 6.0
    assert segment_speeds(CURVE).tolist() == [2.5, 0.0, 0.25]


def test_places():
    assert place_at(CURVE, 2.0) == (1.5, 2.0)
    assert place_at(CURVE, 0.0) == (0.0, 0.0)
    assert place_at(CURVE, 99.0) == (3.0, 5.0)


def test_positions_and_presence():
    lines = WorldLines.from_curves(["a", "b"], [CURVE, np.add(CURVE, [1.0, 0.0, 2.0])])
    places = positions(lines, np.array([20.0, 11.0]), np.array([0.5, 2.0, 4.0, 11.0, 12.0]))
    assert np.isnan(places[0, 0]).all()
    assert places[0, 1:].tolist() == [[1.5, 2.0], [3.0, 4.0], [3.0, 5.0], [3.0, 5.0]]
    assert np.isnan(places[1, :2]).all()
    assert places[1, 2].tolist() == [2.5, 2.0]
    assert places[1, 3].tolist() == [4.0, 5.0]
    assert np.isnan(places[1, 4]).all()
