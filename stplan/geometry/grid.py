"""A uniform grid: which members lie in which cells of space, in any number of dimensions.

Cells are cubes, numbered along the last axis first, so that the cells that a box touches are runs of
consecutive numbers, one for every row of cells along that axis (time, in space-time), and so are
the members that they hold. A question is therefore two loops, whatever the dimension:

    query = make_query(grid.cells)
    query.low[:], query.high[:] = ...
    for r in range(cells_of_box(grid.cells, query)):
        for k in range(grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]):
            member = grid.members[k]

A member that reaches into several cells is met once in each of them.
"""

from __future__ import annotations

from typing import NamedTuple

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inlined, inner, kernel
from stplan.geometry.allocation import new_integer_rows, new_integers, new_numbers
from stplan.geometry.growable import with_room
from stplan.geometry.sorting import counting_sort

# A grid of a sparse scene is made coarser rather than larger, in steps of this factor.
COARSER = 1.26
# No cell is smaller than this (m).
LEAST_SIZE = 1e-9


class Cells(NamedTuple):
    """A box of space cut into cubes.

    Attributes:
        origin: (d,) lowest corner, m.
        size: side of a cell, m.
        shape: (d,) number of cells along every axis.
        total: number of all cells.
    """

    origin: FloatArray
    size: float
    shape: IntArray
    total: int


class Grid(NamedTuple):
    """Cells and what lies in them.

    Attributes:
        cells: where.
        starts: (total + 1,) and
        members: cell k holds ``members[starts[k]:starts[k + 1]]``, rising.
    """

    cells: Cells
    starts: IntArray
    members: IntArray


class Query(NamedTuple):
    """A box to ask with, and the answer: working memory for many questions, one after the other.

    Attributes:
        low, high: (d,) corners of the box, m.
        runs: (R, 2) first cell of every run, and the one past its last.
    """

    low: FloatArray
    high: FloatArray
    runs: IntArray


@inner
def make_cells(low: FloatArray, high: FloatArray, size: float, most: float) -> Cells:
    """Cells from corner `low` to corner `high` (d,), of `size` (m) or as large as `most` cells ask."""
    origin = new_numbers(len(low))
    shape = new_integers(len(low))
    size = max(size, LEAST_SIZE)
    while True:
        total = 1.0
        for x in range(len(low)):
            origin[x] = low[x]
            shape[x] = int((high[x] - low[x]) / size) + 1
            total *= shape[x]
        if total <= most:
            return Cells(origin, size, shape, int(total))
        size *= COARSER


@kernel
def grid_of_boxes(low: FloatArray, high: FloatArray, size: float, most: float) -> Grid:
    """The grid of boxes `low` to `high` (n, d), n > 0, m; points are boxes of no extent.

    Cells have `size` (m), or are as large as `most` of them ask.
    """
    return fill(low, high, size, most)


@inner
def fill(low: FloatArray, high: FloatArray, size: float, most: float) -> Grid:
    """`grid_of_boxes`, for kernels."""
    lowest = new_numbers(low.shape[1])
    highest = new_numbers(low.shape[1])
    for x in range(low.shape[1]):
        lowest[x] = low[0, x]
        highest[x] = high[0, x]
        for member in range(1, len(low)):
            lowest[x] = min(lowest[x], low[member, x])
            highest[x] = max(highest[x], high[member, x])
    cells = make_cells(lowest, highest, size, most)
    query = make_query(cells)
    # Cell and member.
    entries = new_integer_rows(2 * len(low), 2)
    count = 0
    for member in range(len(low)):
        for x in range(len(query.low)):
            query.low[x] = low[member, x]
            query.high[x] = high[member, x]
        for r in range(cells_of_box(cells, query)):
            first, past = query.runs[r, 0], query.runs[r, 1]
            entries = with_room(entries, count + past - first)
            for cell in range(first, past):
                entries[count, 0] = cell
                entries[count, 1] = member
                count += 1
    starts, order = counting_sort(entries[:count], cells.total)
    for k in range(count):
        order[k] = entries[order[k], 1]
    return Grid(cells, starts, order)


@inlined
def make_query(cells: Cells) -> Query:
    """Room for a box and for the runs of any box."""
    dimension = len(cells.shape)
    rows = cells.total // cells.shape[dimension - 1]
    return Query(new_numbers(dimension), new_numbers(dimension), new_integer_rows(rows, 2))


@inlined
def cell_along(cells: Cells, value: float, axis: int) -> int:
    """The cell along an axis in which a coordinate (m) lies, the outermost one outside of the box."""
    place = (value - cells.origin[axis]) / cells.size
    return int(min(max(place, 0.0), cells.shape[axis] - 1.0))


@inlined
def cells_of_box(cells: Cells, query: Query) -> int:
    """Find the runs of cells that touch the box of `query`; returns how many there are."""
    low, high, runs = query
    last = len(cells.shape) - 1
    count = 1
    runs[0, 0] = 0
    for axis in range(last):
        first = cell_along(cells, low[axis], axis)
        width = cell_along(cells, high[axis], axis) - first + 1
        # Backwards, so that no row is overwritten before it has been read.
        for row in range(count - 1, -1, -1):
            above = runs[row, 0] * cells.shape[axis] + first
            for step in range(width):
                runs[row * width + step, 0] = above + step
        count *= width
    first = cell_along(cells, low[last], last)
    past = cell_along(cells, high[last], last) + 1
    for row in range(count):
        above = runs[row, 0] * cells.shape[last]
        runs[row, 0] = above + first
        runs[row, 1] = above + past
    return count
