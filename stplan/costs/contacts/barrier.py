"""Barrier functions of the clearance z > 0, with their derivatives.

The paper's barrier is b(z) = -log z (equations for collision and map cost). Its reach is infinite, so
no neighbour list could be exact. With a finite range h the clamped barrier

    b(z) = -(1 - z/h)^2 log(z/h)   for z < h,   0 beyond,

is twice continuously differentiable, grows like -log z near contact, and vanishes from h on.
"""

from __future__ import annotations

import numpy as np

from stplan.compiled import inner


@inner
def barrier(clearance: float, reach: float) -> tuple[float, float, float]:
    """b, b' (1/m) and b'' (1/m^2) at `clearance` z > 0 in m; `reach` h in m, inf for -log z."""
    if np.isinf(reach):
        return -np.log(clearance), -1.0 / clearance, 1.0 / (clearance * clearance)
    if clearance >= reach:
        return 0.0, 0.0, 0.0
    u = clearance / reach
    rest = 1.0 - u
    log = np.log(u)
    value = -rest * rest * log
    first = (2.0 * rest * log - rest * rest / u) / reach
    second = (-2.0 * log + 4.0 * rest / u + rest * rest / (u * u)) / (reach * reach)
    return value, first, second
