"""Large maps are read in seconds."""

from __future__ import annotations

import time

import numpy as np
import pytest

from stplan.world import build_free_space
from tests.world.scenes import scene


@pytest.mark.claims
def test_a_hundred_thousand_edges() -> None:
    side = 224
    x, y = np.divmod(np.arange(50_000), side)
    angle = np.random.default_rng(0).uniform(0, np.pi, len(x))
    arm = 0.4 * np.column_stack([np.cos(angle), np.sin(angle)])
    middle = np.column_stack([x, y]) + 0.5
    ends = np.round(np.hstack([middle - arm, middle + arm]), 4).tolist()
    lines = ", ".join(f"{{line: [[{a}, {b}], [{c}, {d}]]}}" for a, b, c, d in ends)
    text = f"{{rectangle: [-1, -1, {side + 1}, {side + 1}], obstacles: [{lines}]}}"
    begun = time.process_time()
    space = build_free_space(scene(text))
    # Two to three on a machine at rest.
    assert time.process_time() - begun < 6.0
    assert len(space.boundary_edges) == 100_004
    assert space.area.area == (side + 2) ** 2
