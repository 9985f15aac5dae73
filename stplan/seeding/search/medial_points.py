"""Points in the middle between walls, so that every passage wider than some agent is connected.

They are Voronoi vertices of points along the walls. In passages hardly wider than an agent they are moved to
the very middle; what counts as such is asked of every radius, not of the smallest alone.
"""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import Voronoi

from stplan.arrays import BoolArray, FloatArray
from stplan.deadline import heed
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.wall_distances import least_wall_distances
from stplan.world.free_space import FreeSpace
from stplan.world.sampling import along, inside, rings_of, thinned

# Points along the walls: so many a spacing, and at most so many in all.
SAMPLES_PER_SPACING = 4.0
MAX_SAMPLES = 20000
# They are moved by this part of their distance, so that none lie on common circles.
SHAKE = 1e-6
# Rooms between these multiples of a radius are centred: they may turn out to be wider than it, or hardly.
CENTRED = (0.9, 1.5)
# Bisections that centre a point between its walls.
CENTRING_STEPS = 14


def medial_points(
    free_space: FreeSpace, radii: FloatArray, spacing: float
) -> tuple[FloatArray, FloatArray]:
    """Points (n, 2) with more room than the least of the rising `radii` (K,), and the room of each; m."""
    least = float(radii[0])
    perimeter = float(free_space.polygon.length)
    step = max(min(spacing, least) / SAMPLES_PER_SPACING, perimeter / MAX_SAMPLES)
    samples = np.vstack([along(ring, step) for ring in rings_of(free_space.polygon)])
    samples = np.unique(samples, axis=0)
    # Of many points on common circles, as on a rectangle's sides, Qhull makes very large facets.
    samples += np.random.default_rng(0).uniform(-SHAKE * step, SHAKE * step, samples.shape)
    heed()
    points = inside(free_space.polygon, Voronoi(samples).vertices)
    heed()
    room = free_space.clearance(points)
    heed()
    radius = next_radius(room / CENTRED[1], radii)
    tight = (room > CENTRED[0] * radius) & (room < CENTRED[1] * radius)
    wide = points[(room > least) & ~tight]
    narrow = thinned(points[tight], 0.08 * radius[tight])
    reach = np.full(len(narrow), step)
    points = np.vstack([centred(free_space, narrow, reach), wide])
    room = free_space.clearance(points)
    return points[room > least], room[room > least]


def next_radius(room: FloatArray, radii: FloatArray) -> FloatArray:
    """(n,) the least of the rising `radii` (K,) that is more than each `room` (n,), inf above all."""
    return np.append(radii, np.inf)[np.searchsorted(radii, room, side="right")]


def slack(room: FloatArray, radii: FloatArray) -> FloatArray:
    """(n,) each `room` (n,) over the greatest of the rising `radii` (K,) below it, inf if there is none."""
    below = np.searchsorted(radii, room, side="left") - 1
    return np.where(below >= 0, room / radii[np.maximum(below, 0)], np.inf)


def centred(free_space: FreeSpace, points: FloatArray, reach: FloatArray) -> FloatArray:
    """`points` (n, 2), m, moved by at most `reach` (n,) away from their nearest wall to the most room."""
    if len(points) == 0:
        return points
    segments = free_space.boundary_segments
    walls = shapely.linestrings(segments.reshape(-1, 2, 2))
    nearest = shapely.STRtree(walls).query_nearest(shapely.points(points), all_matches=False)[1]
    head, tail = segments[nearest, :2], segments[nearest, 2:]
    share = ((points - head) * (tail - head)).sum(axis=1) / ((tail - head) ** 2).sum(axis=1)
    away = points - (head + np.clip(share, 0.0, 1.0)[:, None] * (tail - head))
    away /= np.maximum(np.hypot(away[:, 0], away[:, 1]), 1e-12)[:, None]
    low, high = np.zeros(len(points)), reach.copy()
    grid = BoundaryGrid.from_segments(segments)

    def room(part: FloatArray) -> FloatArray:
        moved = points + part[:, None] * away
        # Moved by no more than the reach, nothing gets further off a wall than this.
        return least_wall_distances(moved, moved, gap, grid)

    gap = float(free_space.clearance(points).max() + 2.0 * reach.max())
    for _ in range(CENTRING_STEPS):
        heed()
        first, second = low + (high - low) / 3, high - (high - low) / 3
        rises: BoolArray = room(first) < room(second)
        low, high = np.where(rises, first, low), np.where(rises, high, second)
    result: FloatArray = points + ((low + high) / 2)[:, None] * away
    return result
