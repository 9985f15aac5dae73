"""Fresh arrays have the shapes and types that compiled code is written for."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.compiled import kernel
from stplan.geometry.allocation import (
    new_flags,
    new_integer_rows,
    new_integers,
    new_number_rows,
    new_numbers,
)


@kernel
def _of_each(count: int, width: int) -> tuple:
    return (
        new_integers(count),
        new_integer_rows(count, width),
        new_numbers(count),
        new_number_rows(count, width),
        new_flags(count),
    )


@pytest.mark.parametrize("count", [0, 5])
def test_shapes_and_types(count: int) -> None:
    types = [np.int64, np.int64, np.float64, np.float64, np.bool_]
    shapes = [(count,), (count, 3), (count,), (count, 3), (count,)]
    for made in (_of_each, _of_each.py_func):
        arrays = made(count, 3)
        assert [array.dtype for array in arrays] == types
        assert [array.shape for array in arrays] == shapes
        assert all(array.flags.c_contiguous and array.flags.writeable for array in arrays)
