"""The grid against brute force: nothing that a box touches is missed, in any dimension."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.grid import Grid, cells_of_box, grid_of_boxes, make_cells, make_query
from stplan.geometry.growable import with_room


@kernel
def _members_near(grid: Grid, low: FloatArray, high: FloatArray) -> IntArray:
    query = make_query(grid.cells)
    for x in range(len(low)):
        query.low[x] = low[x]
        query.high[x] = high[x]
    found = np.empty((1, 1), np.int64)
    count = 0
    for r in range(cells_of_box(grid.cells, query)):
        begin, past = grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]
        found = with_room(found, count + past - begin)
        for k in range(begin, past):
            found[count, 0] = grid.members[k]
            count += 1
    return found[:count, 0].copy()


def members_near(grid: Grid, low: FloatArray, high: FloatArray) -> list[int]:
    """What the cells that touch a box hold, as often as they do."""
    return _members_near(grid, low, high).tolist()


def touching(low: FloatArray, high: FloatArray, box: FloatArray) -> set[int]:
    """Boxes `low` to `high` (n, d) that touch the box (2, d)."""
    return set(np.flatnonzero(((low <= box[1]) & (high >= box[0])).all(axis=1)).tolist())


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
@pytest.mark.parametrize("size", [0.05, 0.7, 50.0])
def test_no_member_that_a_box_touches_is_missed(dimension: int, size: float) -> None:
    rng = np.random.default_rng(dimension)
    low = rng.uniform(-4, 4, (60, dimension))
    high = low + rng.uniform(0, 1.5, low.shape) * rng.integers(0, 2, (60, 1))
    grid = grid_of_boxes(low, high, size, 5000.0)
    assert grid.cells.total == grid.cells.shape.prod() <= 5000
    for _ in range(40):
        corners = np.sort(rng.uniform(-6, 6, (2, dimension)), axis=0)
        found = members_near(grid, *corners)
        assert touching(low, high, corners) <= set(found)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.integers(-8, 8), st.integers(-8, 8)), min_size=1, max_size=12),
    st.tuples(st.integers(-9, 9), st.integers(-9, 9), st.integers(0, 5), st.integers(0, 5)),
    st.sampled_from([0.5, 1.0, 3.0]),
)
def test_points_on_the_lines_between_cells_are_found_once(
    points: list[tuple[int, int]], box: tuple[int, int, int, int], size: float
) -> None:
    places = np.array(points, dtype=np.float64)
    grid = grid_of_boxes(places, places, size, 1e4)
    low = np.array(box[:2], dtype=np.float64)
    corners = np.stack([low, low + box[2:]])
    found = members_near(grid, *corners)
    assert len(found) == len(set(found))
    assert touching(places, places, corners) <= set(found)


def test_members_of_a_cell_rise_and_every_member_is_in_some_cell() -> None:
    rng = np.random.default_rng(3)
    low = rng.uniform(0, 5, (80, 2))
    high = low + 1.0
    grid = grid_of_boxes(low, high, 0.8, 1000.0)
    cells = np.split(grid.members, grid.starts[1:-1])
    assert len(cells) == grid.cells.total
    assert all((np.diff(cell) > 0).all() for cell in cells)
    assert set(grid.members.tolist()) == set(range(80))


def test_a_box_far_outside_asks_the_outermost_cells() -> None:
    places = np.array([[0.0, 0.0], [1.0, 1.0]])
    grid = grid_of_boxes(places, places, 0.5, 100.0)
    assert members_near(grid, np.full(2, -np.inf), np.full(2, np.inf)) == [0, 1]
    assert members_near(grid, np.full(2, 7.0), np.full(2, 9.0)) == [1]


def test_a_grid_of_a_sparse_scene_is_coarser_rather_than_larger() -> None:
    cells = make_cells(np.zeros(3), np.full(3, 1e6), 0.1, 1000)
    assert cells.total <= 1000
    assert cells.size >= 1e5 * 0.9
    assert make_cells(np.zeros(2), np.ones(2), 0.0, 50).total <= 50
