"""Fresh arrays for compiled code.

numba compiles `np.empty` anew at nearly every place it is called from; these are compiled once.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inner


@inner
def new_integers(count: int) -> IntArray:
    """(count,) of anything."""
    return np.empty(count, np.int64)


@inner
def new_integer_rows(count: int, width: int) -> IntArray:
    """(count, width) of anything."""
    return np.empty((count, width), np.int64)


@inner
def new_numbers(count: int) -> FloatArray:
    """(count,) of anything."""
    return np.empty(count)


@inner
def new_number_rows(count: int, width: int) -> FloatArray:
    """(count, width) of anything."""
    return np.empty((count, width))


@inner
def new_flags(count: int) -> BoolArray:
    """(count,) of anything."""
    return np.empty(count, np.bool_)
