"""Another number of knots for the same curve: new knots lie on the polyline, old ones stay."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray


def resample_curve(curve: FloatArray, num_knots: int) -> FloatArray:
    """`curve` (n, 3) with exactly `num_knots` knots, all of the old ones among them.

    Pieces are split where they are longest, in parts of the duration plus parts of the length. A
    curve that has as many knots already, or more, comes back as it is.
    """
    wanted = num_knots - len(curve)
    if wanted <= 0:
        return curve.copy()
    if len(curve) == 2:
        parts = np.arange(num_knots - 1) / (num_knots - 1)
        return np.vstack([curve[0] + (curve[1] - curve[0]) * parts[:, None], curve[1:]])
    duration = np.diff(curve[:, 2])
    length = np.hypot(*np.diff(curve[:, :2], axis=0).T)
    weight = duration / duration.sum() + length / max(float(length.sum()), 1e-9)
    # Every piece gets at least the whole part of its fair share; the rest go one by one.
    pieces = 1 + (wanted * weight / weight.sum() * (1.0 - 1e-12)).astype(np.int64)
    for _ in range(len(weight) + wanted - int(pieces.sum())):
        pieces[np.argmax(weight / pieces)] += 1
    found = [
        curve[i] + (curve[i + 1] - curve[i]) * (np.arange(count) / count)[:, None]
        for i, count in enumerate(pieces)
    ]
    return np.ascontiguousarray(np.vstack([*found, curve[-1:]]))
