"""Results that do not fit: an array that lacks room for more rows makes way for a longer one."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from stplan.compiled import inner

Rows = TypeVar("Rows", bound=NDArray[Any])


@inner
def with_room(rows: Rows, count: int) -> Rows:
    """`rows` (n, k) if there are at least `count` of them, else a copy more than twice as long.

    Asked for before rows are written, ``rows = with_room(rows, count)``, and outside of the innermost
    loop, with the most that it may write: an array that may be replaced cannot stay in registers. Copying
    takes a constant time a row in all, however many there are in the end.
    """
    if count <= len(rows):
        return rows
    longer: Any = np.empty((2 * count, rows.shape[1]), rows.dtype)
    for i in range(len(rows)):
        for k in range(rows.shape[1]):
            longer[i, k] = rows[i, k]
    return longer
