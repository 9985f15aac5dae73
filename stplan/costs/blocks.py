"""Blocks of 3 x 3 second derivatives between two knots, as entries of a lower triangle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.nlp.term import Structure

# Lower triangle of a 3 x 3 diagonal block, and a full off-diagonal one, row by row.
_LOWER = np.array([(x, y) for x in range(3) for y in range(x + 1)])
_FULL = np.array([(x, y) for x in range(3) for y in range(3)])


def block_structure(rows: IntArray, columns: IntArray) -> Structure:
    """Variables of 3 x 3 blocks of knots (row knot >= column knot), in the order of `pack_blocks`.

    Diagonal blocks (row == column) hold their lower triangle. All blocks of one call are of one kind.
    """
    pattern = _LOWER if len(rows) and rows[0] == columns[0] else _FULL
    row = 3 * rows[:, None] + pattern[:, 0]
    column = 3 * columns[:, None] + pattern[:, 1]
    return row.ravel(), column.ravel()


def joined_structure(pairs: Sequence[tuple[IntArray, IntArray]]) -> Structure:
    """`block_structure` of several kinds of blocks, one after another."""
    parts = [block_structure(rows, columns) for rows, columns in pairs]
    return np.concatenate([rows for rows, _ in parts]), np.concatenate([cols for _, cols in parts])


def pack_blocks(blocks: FloatArray, diagonal: bool) -> FloatArray:
    """Values of (B, 3, 3) blocks in the order of `block_structure`."""
    pattern = _LOWER if diagonal else _FULL
    return np.ascontiguousarray(blocks[:, pattern[:, 0], pattern[:, 1]]).ravel()
