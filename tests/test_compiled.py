"""How kernels are compiled: what Python may call, and what it runs as written."""

from __future__ import annotations

import numpy as np

from stplan.compiled import inlined, inner, kernel


@inlined
def _twice(value: float) -> float:
    return 2.0 * value


@inner
def _total(values: np.ndarray) -> float:
    total = 0.0
    for k in range(len(values)):
        total += _twice(values[k])
    return total


@kernel
def doubled(values: np.ndarray) -> float:
    return _total(values)


def test_kernels_call_what_is_linked_or_inlined() -> None:
    assert doubled(np.array([1.0, 2.5])) == 7.0


def test_a_call_from_python_runs_the_function_itself() -> None:
    # A list would be refused by compiled code.
    assert _total([1.0, 2.5]) == 7.0  # type: ignore[arg-type]
    assert _twice(3.0) == 6.0
    assert _total.signatures == [] or _total(np.ones(2)) == 4.0  # type: ignore[attr-defined]
