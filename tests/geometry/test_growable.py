"""Arrays that grow keep what they hold."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.compiled import kernel
from stplan.geometry.growable import with_room


@kernel
def counted(steps: np.ndarray) -> np.ndarray:
    """(n, 2) rows written in bursts of `steps`, into an array of one row at first."""
    rows = np.empty((1, 2), np.int64)
    count = 0
    for k in range(len(steps)):
        rows = with_room(rows, count + steps[k])
        for _ in range(steps[k]):
            rows[count, 0] = count
            rows[count, 1] = k
            count += 1
    return rows[:count]


@pytest.mark.parametrize("steps", [[], [0, 0], [1], [3, 0, 1, 50, 2], [1] * 300])
def test_rows_written_into_an_array_that_grows_are_all_there(steps: list[int]) -> None:
    found = counted(np.array(steps, dtype=np.int64))
    assert found[:, 0].tolist() == list(range(sum(steps)))
    assert found[:, 1].tolist() == np.repeat(np.arange(len(steps)), steps).tolist()


@pytest.mark.parametrize("dtype", [np.int32, np.int64])
def test_an_array_with_room_stays_as_it_is(dtype: type) -> None:
    rows = np.zeros((4, 3), dtype=dtype)
    assert with_room(rows, 4) is rows
    longer = with_room(rows, 5)
    assert longer.dtype == dtype
    assert longer.shape[0] >= 5
    assert longer.shape[1] == 3
