"""A tree of bounding boxes over segments in the plane: near ones are found without looking at the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inner

# Segments in one leaf.
LEAF = 4
# Steps of the grid along either axis that orders segments.
_STEPS = 2**16 - 1


@dataclass(frozen=True)
class BoxTree:
    """A complete binary tree: node i has children 2 i and 2 i + 1, the root is 1.

    Attributes:
        boxes: (2 P, 4) xmin, ymin, xmax, ymax of every node, m; of an empty one the wrong way round.
        order: (S,) segments in the order of leaves: leaf P + k holds ``order[LEAF * k : LEAF * (k + 1)]``.
    """

    boxes: FloatArray
    order: IntArray

    @staticmethod
    def over(segments: FloatArray) -> BoxTree:
        """The tree over `segments` (S, 4), x0, y0, x1, y1; neighbours in the plane share leaves."""
        order = np.argsort(_curve_order(segments), kind="stable").astype(np.int64)
        count = -(-len(segments) // LEAF)
        leaves = 1 << max(count - 1, 0).bit_length()
        low = np.full((leaves * LEAF, 2), np.inf)
        high = np.full((leaves * LEAF, 2), -np.inf)
        low[: len(order)] = np.minimum(segments[:, :2], segments[:, 2:])[order]
        high[: len(order)] = np.maximum(segments[:, :2], segments[:, 2:])[order]
        level = np.hstack(
            [low.reshape(-1, LEAF, 2).min(axis=1), high.reshape(-1, LEAF, 2).max(axis=1)]
        )
        levels = [level]
        while len(level) > 1:
            pairs = level.reshape(-1, 2, 4)
            level = np.hstack([pairs[:, :, :2].min(axis=1), pairs[:, :, 2:].max(axis=1)])
            levels.append(level)
        unused = np.zeros((1, 4))
        return BoxTree(np.ascontiguousarray(np.vstack([unused, *reversed(levels)])), order)


def _curve_order(segments: FloatArray) -> IntArray:
    """Place of every segment's middle on a curve that fills the plane (Morton's)."""
    middles = 0.5 * (segments[:, :2] + segments[:, 2:])
    low = middles.min(axis=0)
    extent = max(float((middles.max(axis=0) - low).max()), 2.0**-500)
    steps = ((middles - low) / extent * _STEPS).astype(np.int64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        steps = (steps | (steps << shift)) & mask
    code: IntArray = steps[:, 0] | (steps[:, 1] << 1)
    return code


@inner
def box_distance(
    box: FloatArray, low_x: float, low_y: float, high_x: float, high_y: float
) -> float:
    """Distance of two boxes in m, 0 where they overlap, inf to an empty one."""
    x = max(box[0] - high_x, low_x - box[2], 0.0)
    y = max(box[1] - high_y, low_y - box[3], 0.0)
    return np.sqrt(x * x + y * y)
