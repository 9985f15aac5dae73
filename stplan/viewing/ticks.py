"""Round numbers for scale bars and moments."""

from __future__ import annotations

import numpy as np


def nice_step(span: float, most: int) -> float:
    """The smallest of 1, 2, 5 times a power of ten that divides `span` into at most `most` parts."""
    if span <= 0:
        return 1.0
    rough = span / most
    power = 10.0 ** np.floor(np.log10(rough))
    return float(
        next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough * 0.999)
    )
