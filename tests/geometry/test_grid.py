"""The grid against brute force: nothing that a box touches is missed, in any dimension."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stplan.arrays import FloatArray
from stplan.geometry.grid import Grid, cells_of_box, make_cells, make_grid, make_query


def members_near(grid: Grid, low: FloatArray, high: FloatArray) -> list[int]:
    """What the cells that touch a box hold, as often as they do."""
    query = make_query(grid.cells)
    query.low[:], query.high[:] = low, high
    found = []
    for r in range(cells_of_box(grid.cells, query)):
        begin, past = grid.starts[query.runs[r, 0]], grid.starts[query.runs[r, 1]]
        found += grid.members[begin:past].tolist()
    return found


def touching(low: FloatArray, high: FloatArray, box: FloatArray) -> set[int]:
    """Boxes `low` to `high` (n, d) that touch the box (2, d)."""
    return set(np.flatnonzero(((low <= box[1]) & (high >= box[0])).all(axis=1)).tolist())


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
@pytest.mark.parametrize("size", [0.05, 0.7, 50.0])
def test_no_member_that_a_box_touches_is_missed(dimension: int, size: float) -> None:
    rng = np.random.default_rng(dimension)
    low = rng.uniform(-4, 4, (60, dimension))
    high = low + rng.uniform(0, 1.5, low.shape) * rng.integers(0, 2, (60, 1))
    grid = make_grid(make_cells(low.min(axis=0), high.max(axis=0), size, 5000), low, high)
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
    grid = make_grid(make_cells(places.min(axis=0), places.max(axis=0), size, 1e4), places, places)
    low = np.array(box[:2], dtype=np.float64)
    corners = np.stack([low, low + box[2:]])
    found = members_near(grid, *corners)
    assert len(found) == len(set(found))
    assert touching(places, places, corners) <= set(found)


def test_members_of_a_cell_rise_and_every_member_is_in_some_cell() -> None:
    rng = np.random.default_rng(3)
    low = rng.uniform(0, 5, (80, 2))
    high = low + 1.0
    grid = make_grid(make_cells(low.min(axis=0), high.max(axis=0), 0.8, 1000), low, high)
    cells = np.split(grid.members, grid.starts[1:-1])
    assert len(cells) == grid.cells.total
    assert all((np.diff(cell) > 0).all() for cell in cells)
    assert set(grid.members.tolist()) == set(range(80))


def test_a_box_far_outside_asks_the_outermost_cells() -> None:
    places = np.array([[0.0, 0.0], [1.0, 1.0]])
    grid = make_grid(make_cells(places[0], places[1], 0.5, 100), places, places)
    assert members_near(grid, np.full(2, -np.inf), np.full(2, np.inf)) == [0, 1]
    assert members_near(grid, np.full(2, 7.0), np.full(2, 9.0)) == [1]


def test_a_grid_of_a_sparse_scene_is_coarser_rather_than_larger() -> None:
    cells = make_cells(np.zeros(3), np.full(3, 1e6), 0.1, 1000)
    assert cells.total <= 1000
    assert cells.size >= 1e5 * 0.9
    assert make_cells(np.zeros(2), np.ones(2), 0.0, 50).total <= 50
