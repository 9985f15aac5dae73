"""Rods: the space that an agent's disc sweeps in (x, y, height), as triangle meshes.

Between knots the disc moves at constant velocity, so the rod is a sheared cylinder with level discs for
rings: a ring of corners a knot is exact but for the corners' number.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray


def rod_curve(curve: FloatArray, leaves: float) -> FloatArray:
    """A curve (n + 1, 3) with its stand on the goal until `leaves` s, where there is one."""
    if leaves <= curve[-1, 2]:
        return curve
    return np.vstack([curve, [*curve[-1, :2], leaves]])


def rod_mesh(curve: FloatArray, radius: float, sides: int) -> tuple[FloatArray, IntArray]:
    """Closed mesh around `curve` (n + 1, 3) in (x, y, height): vertices (V, 3), triangles (F, 3).

    Triangles face outwards. The corners lie on the disc's rim.
    """
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sides)])
    rings = (curve[:, None, :] + rim[None, :, :]).reshape(-1, 3)
    count = len(curve)
    corner = np.arange(sides)
    following = (corner + 1) % sides
    base = (np.arange(count - 1) * sides)[:, None]
    low, low_next = base + corner, base + following
    high, high_next = low + sides, low_next + sides
    mantle = np.stack(
        [np.stack([low, low_next, high_next], axis=-1), np.stack([low, high_next, high], axis=-1)],
        axis=2,
    ).reshape(-1, 3)
    bottom, top = len(rings), len(rings) + 1
    last = (count - 1) * sides
    ends = np.vstack(
        [
            np.column_stack([np.full(sides, bottom), following, corner]),
            np.column_stack([np.full(sides, top), last + corner, last + following]),
        ]
    )
    vertices = np.vstack([rings, curve[:1], curve[-1:]])
    return vertices, np.vstack([mantle, ends]).astype(np.int64)
