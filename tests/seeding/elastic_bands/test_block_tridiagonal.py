"""The solver of one band's system against a dense one."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.arrays import IntArray
from stplan.compiled import kernel
from stplan.seeding.elastic_bands.block_tridiagonal import (
    FIXED,
    FREE,
    PINNED,
    Chain,
    hold_knots,
    solve,
)


@kernel
def held_and_solved(hold: IntArray, chain: Chain) -> None:
    """The system of a chain solved in place, some coordinates held."""
    hold_knots(hold, chain)
    solve(chain, len(hold))


def test_the_chain_solver_equals_a_dense_one() -> None:
    rng = np.random.default_rng(0)
    count = 7
    dense = np.zeros((3 * count, 3 * count))
    for i in range(count - 1):
        part = rng.normal(size=(6, 6))
        dense[3 * i : 3 * i + 6, 3 * i : 3 * i + 6] += part @ part.T + np.eye(6)
    force = rng.normal(size=(count, 3))
    diagonal = np.stack([dense[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] for i in range(count)])
    upper = np.zeros((count, 3, 3))
    for i in range(count - 1):
        upper[i] = dense[3 * i : 3 * i + 3, 3 * i + 3 : 3 * i + 6]
    hold = np.full(count, FREE)
    hold[[0, 3, 6]] = FIXED, PINNED, FIXED
    free = np.ones(3 * count, dtype=bool)
    free[[0, 1, 2, 9, 10, 18, 19, 20]] = False
    expected = np.zeros(3 * count)
    expected[free] = np.linalg.solve(dense[np.ix_(free, free)], force.ravel()[free])
    # Room for more knots than there are, as where bands have unequal numbers.
    chain = Chain(
        *(np.full((count + 2, *part.shape[1:]), np.nan) for part in (diagonal, upper, force, upper))
    )
    for place, part in zip(chain, (diagonal, upper, force), strict=False):
        place[:count] = part
    held_and_solved(hold, chain)
    assert chain.force[:count].ravel() == pytest.approx(expected)
