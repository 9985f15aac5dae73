"""Kinetic cost of single curves: sum_i 1/2 m |dx_i|^2 / dt_i, in J s (the paper's, without its weight).

The optimiser's term with its derivatives is `stplan.costs`'; whoever only measures curves does it here.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stplan.arrays import FloatArray


def kinetic_cost(mass: float, curve: FloatArray) -> float:
    """Of a curve (n + 1, 3) as x, y [m], t [s]; `mass` in kg."""
    step = np.diff(curve, axis=0)
    return float((0.5 * mass * (step[:, :2] ** 2).sum(axis=1) / step[:, 2]).sum())


def total_kinetic_cost(masses: Iterable[float], curves: Iterable[FloatArray]) -> float:
    """Of all agents together."""
    agents = zip(masses, curves, strict=True)
    return sum(kinetic_cost(mass, curve) for mass, curve in agents)


def least_kinetic_cost(mass: float, stops: FloatArray, duration: float) -> float:
    """Of going straight from stop to stop (s, 2) at constant speed, in `duration` s in all."""
    length = float(np.hypot(*np.diff(stops, axis=0).T).sum())
    return 0.5 * mass * length**2 / duration
