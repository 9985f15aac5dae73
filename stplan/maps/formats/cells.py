"""Cells of a grid -> polygons along their edges, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from stplan.arrays import BoolArray, IntArray
from stplan.maps.formats.drawing import FormatError

# Cells of the largest grid.
MOST_CELLS = 25_000_000
# Corners of the outlines of all its parts.
MOST_CORNERS = 1_000_000


def check_cells(width: int, height: int) -> None:
    """Raise FormatError for a grid without cells, or with more than are read."""
    if width < 1 or height < 1:
        raise FormatError(f"is {width} x {height} cells; at least one is expected")
    if width * height > MOST_CELLS:
        raise FormatError(f"is {width} x {height} cells, at most {MOST_CELLS} are read")


def cell_polygons(free: BoolArray) -> tuple[Any, ...]:
    """The free cells (H, W) as polygons in units of a cell, row 0 on top, y upwards from the last row.

    Cells that touch at a corner only are not joined: nothing passes there.

    Raises:
        FormatError: the outline has too many corners.
    """
    height, _ = free.shape
    padded = np.pad(free, 1)
    # Whether the edge below (to the left of) a grid point's cell parts free from blocked.
    across = padded[1:, 1:-1] != padded[:-1, 1:-1]
    upright = padded[1:-1, 1:] != padded[1:-1, :-1]
    corners = _corners(across, upright)
    if int(corners.sum()) > MOST_CORNERS:
        raise FormatError(
            f"has outlines with more than {MOST_CORNERS} corners; simplify the picture"
        )
    level, steep = _runs(across, corners), _runs(upright.T, corners.T)
    sides = np.vstack([level, steep[:, [1, 0, 3, 2]]]).astype(np.float64)
    sides = sides.reshape(-1, 2, 2)
    sides[:, :, 1] = height - sides[:, :, 1]
    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(sides)))
    if not len(faces):
        return ()
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    column = inside[:, 0].astype(np.int64)
    row = (height - inside[:, 1]).astype(np.int64)
    return tuple(faces[free[row, column]])


def _corners(across: BoolArray, upright: BoolArray) -> BoolArray:
    """(H + 1, W + 1) grid points at which the outline turns or crosses itself."""
    left, right = np.pad(across, ((0, 0), (1, 0))), np.pad(across, ((0, 0), (0, 1)))
    above, below = np.pad(upright, ((1, 0), (0, 0))), np.pad(upright, ((0, 1), (0, 0)))
    return (left | right) & (above | below)


def _runs(sides: BoolArray, corners: BoolArray) -> IntArray:
    """(S, 4) ends x0, y0, x1, y1 of straight runs of horizontal `sides` between `corners`."""
    row, column = np.nonzero(corners)
    same = np.flatnonzero(row[:-1] == row[1:])
    here = same[sides[row[same], column[same]]]
    return np.column_stack([column[here], row[here], column[here + 1], row[here]])
