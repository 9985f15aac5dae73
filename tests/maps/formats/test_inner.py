"""Simpler outlines stay inside, within the tolerance, and have fewer corners."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stplan.maps.formats.cells import cell_polygons
from stplan.maps.formats.inner import inner_polygons


def noise(seed: int, size: int = 60) -> np.ndarray:
    """Blobs with ragged edges, specks and diagonal touches."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    field = sum(
        np.hypot(x - a, y - b) < c for a, b, c in rng.uniform((0, 0, 4), (size, size, 14), (9, 3))
    )
    return (field > 0) ^ (rng.random((size, size)) < 0.03)


@pytest.mark.parametrize("seed", range(4))
def test_cells_become_polygons_exactly(seed: int) -> None:
    free = noise(seed)
    polygons = np.array(cell_polygons(free), dtype=object)
    assert shapely.is_valid(polygons).all()
    assert shapely.area(polygons).sum() == pytest.approx(free.sum())
    row, column = np.nonzero(free)
    whole = shapely.union_all(polygons)
    assert shapely.contains_xy(whole, column + 0.5, len(free) - row - 0.5).all()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("tolerance", [0.8, 1.0, 3.0])
def test_simpler_polygons_never_gain_floor(seed: int, tolerance: float) -> None:
    polygons = np.array(cell_polygons(noise(seed)), dtype=object)
    simpler = inner_polygons(polygons, tolerance)
    assert shapely.is_valid(simpler).all()
    before, after = shapely.union_all(polygons), shapely.union_all(simpler)
    assert after.difference(before).area < 1e-9
    assert shapely.get_num_coordinates(simpler).sum() < shapely.get_num_coordinates(polygons).sum()
    # What is lost lies within the tolerance of the old outline.
    lost = before.difference(after)
    assert lost.difference(before.boundary.buffer(tolerance + 1e-9)).area < 1e-9


def test_stairs_become_slopes() -> None:
    size = 20
    free = np.tri(size, dtype=bool)
    (polygon,) = inner_polygons(np.array(cell_polygons(free), dtype=object), 1.0)
    assert shapely.get_num_coordinates(polygon) <= 6
    assert polygon.area == pytest.approx(free.sum(), rel=0.06)


def test_without_a_tolerance_nothing_changes() -> None:
    polygons = np.array(cell_polygons(noise(1)), dtype=object)
    assert inner_polygons(polygons, 0.0) is polygons
