"""How often outlines cross, before anything is done that takes time for every crossing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely

from stplan.arrays import BoolArray, FloatArray

# Crossings of all lines that are read; beyond it a scribble is meant to take forever.
MOST_CROSSINGS = 30_000
# Fewer segments than these cannot cross too often.
_FEW = 800
# Segments whose crossings are counted, and pairs of segments that are looked at for it in all.
_SAMPLE, _PAIRS = 64, 20_000_000


def lines_tangle(lines: Sequence[FloatArray]) -> bool:
    """Whether polylines (n, 2) cross each other or themselves more than `MOST_CROSSINGS` times."""
    long = [one for one in lines if len(one) > 1]
    if not long:
        return False
    return _tangled(np.vstack([np.hstack([one[:-1], one[1:]]) for one in long]))


def shapes_tangle(shapes: Sequence[Any]) -> bool:
    """Whether the outlines of shapes cross each other or themselves more than `MOST_CROSSINGS` times."""
    parts = shapely.get_parts(np.array(list(shapes), dtype=object))
    filled = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    rings = np.concatenate([shapely.get_rings(parts[filled]), parts[~filled]])
    points, owner = shapely.get_coordinates(rings, return_index=True)
    return _tangled(np.hstack([points[:-1], points[1:]])[owner[:-1] == owner[1:]])


def _tangled(segments: FloatArray) -> bool:
    """The crossings of some segments (n, 4), chosen without a pattern, stand for those of all."""
    count = len(segments)
    if count <= _FEW:
        return False
    size = max(4, min(_SAMPLE, _PAIRS // max(count, 1)))
    chosen = np.random.default_rng(0).choice(count, min(size, count), replace=False)
    crossings = sum(int(_crossed(segment, segments).sum()) for segment in segments[chosen])
    return crossings / len(chosen) * count / 2 > MOST_CROSSINGS


def _crossed(segment: FloatArray, segments: FloatArray) -> BoolArray:
    """(n,) which of `segments` (n, 4) a segment crosses; touching is no crossing."""
    x, y, to_x, to_y = segment
    near = (
        (np.minimum(segments[:, 0], segments[:, 2]) < max(x, to_x))
        & (np.maximum(segments[:, 0], segments[:, 2]) > min(x, to_x))
        & (np.minimum(segments[:, 1], segments[:, 3]) < max(y, to_y))
        & (np.maximum(segments[:, 1], segments[:, 3]) > min(y, to_y))
    )
    found = np.zeros(len(segments), dtype=bool)
    a, b = segments[near, :2], segments[near, 2:]
    head, tail = segment[:2], segment[2:]
    parted = _side(head, tail, a) * _side(head, tail, b) < 0
    found[near] = parted & (_side(a, b, head) * _side(a, b, tail) < 0)
    return found


def _side(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """-1, 0, 1: on which side of a line from a to b a place is."""
    along, off = b - a, c - a
    return np.sign(along[..., 0] * off[..., 1] - along[..., 1] * off[..., 0])
