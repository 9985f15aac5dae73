"""A coarse roadmap: about as many vertices as agents find room for, so that joint positions stay few.

Places come first, then the middles of passages, the roomiest first, which are where passages meet, and then a
fill. All of them are a body apart or so: finer roadmaps have many positions that differ by nothing that
matters to who gets past whom.
"""

from __future__ import annotations

import math

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.deadline import heed
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.seeding.search.graph import make_graph
from stplan.seeding.search.roadmap import Roadmap
from stplan.world.erosion import eroded
from stplan.world.sampling import box_around, delaunay_edges, hexagonal_points, thinned

# Edges reach so many spacings.
LONGEST = 2.5
# Room in radii up to which the roomier of two places is taken first.
ROOMY = 3.0
# Lengths that differ by this share of the least pitch of a lattice are the same.
SAME = 1e-6
# More vertices than this are not worth searching.
MOST_VERTICES = 4000


def coarse_roadmap(
    problem: PlanningProblem, required: Requirement, diameters: float
) -> Roadmap | None:
    """The roadmap whose vertices are so many least diameters apart, None where it is too large."""
    from stplan.seeding.search.medial_points import medial_points

    space = problem.free_space
    stops = np.vstack(problem.stops)
    radii = np.unique(required.walls[~problem.prescribed])
    least = float(radii[0])
    apart = diameters * 2.0 * float(problem.radii[~problem.prescribed].min())
    places, place_of = np.unique(stops, axis=0, return_inverse=True)
    region = box_around(places, 4.0 * apart) if space is None else space.polygon
    if region.area > MOST_VERTICES * apart * apart:
        return None
    heed()
    offers = [_lattice(places, region, apart)]
    if space is not None:
        middles, room = medial_points(space, radii, apart / 4)
        offers.append(middles[np.argsort(-np.minimum(room, ROOMY * least), kind="stable")])
        region = eroded(region, least, quad_segs=16)
    offers.append(hexagonal_points(region, apart))
    others = np.vstack(offers)
    if space is not None:
        others = others[space.clearance(others) > least]
    heed()
    points = thinned(
        np.vstack([places, others]),
        np.concatenate([np.zeros(len(places)), np.full(len(others), apart)]),
    )
    edges = delaunay_edges(points)
    step = points[edges[:, 1]] - points[edges[:, 0]]
    edges = edges[np.hypot(step[:, 0], step[:, 1]) <= LONGEST * apart]
    heed()
    clearance = np.full(len(points) + len(edges), np.inf)
    if space is not None:
        along = space.segment_clearance(points[edges[:, 0]], points[edges[:, 1]])
        clearance = np.concatenate([space.clearance(points), along])
    return Roadmap(make_graph(points, edges, clearance), np.ravel(place_of).astype(np.int64))


def _lattice(places: FloatArray, region: shapely.Geometry, least: float) -> FloatArray:
    """Points (n, 2) of the square lattice that `places` (P, 2) are on, of a pitch of at least `least`, m.

    Where people stand in rows, so do the places between them. None where they are on no such lattice.
    """
    pitch = 0.0
    for step in np.abs(places - places[0]).ravel().tolist():
        pitch = _common_measure(pitch, step, SAME * least)
    parts = math.floor(pitch / least)
    if parts < 1:
        return np.empty((0, 2))
    pitch /= parts
    low, high = (np.array(region.bounds)[ends] for ends in ([0, 1], [2, 3]))
    first, last = np.ceil((low - places[0]) / pitch), np.floor((high - places[0]) / pitch)
    x, y = (np.arange(first[k], last[k] + 1) * pitch + places[0, k] for k in range(2))
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


def _common_measure(first: float, second: float, rounding: float) -> float:
    """The greatest length of which both are multiples, but for `rounding`."""
    while second > rounding:
        first, second = second, math.fmod(first, second)
        if first - second < rounding:
            second = 0.0
    return first
