"""A maze between hedges, drawn with as many edges as one likes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import networkx as nx
import numpy as np
import shapely
from shapely.geometry.polygon import orient

from stplan.arrays import Point
from stplan.bench.families_tight import RADIUS, make_scene
from stplan.maps.polygon import PolygonBase
from stplan.maps.spec import MapSpec
from stplan.scene.model import Scene

# Lanes fit two agents and a little more, so that they can pass one another.
LANE = 6.0 * RADIUS
HEDGE = 1.2 * RADIUS
# Hedges swing in and out: wave length and depth (m).
WAVE = 4.0 * RADIUS
DEPTH = 0.2 * RADIUS
CELLS = 8
# Openings beyond the tree that connects all cells: they make islands and ways to choose from.
LOOPS = 8
SECONDS = 150.0


def maze(edges: int, rng_seed: int = 0, knots: int = 200) -> Scene:
    """Three agents go from corner to corner of a maze whose walls have about `edges` edges.

    The maze and the journeys depend on `rng_seed` alone: more edges draw the same hedges more finely.
    """
    floor = maze_floor(np.random.default_rng(rng_seed))
    step = floor.length / edges
    outer, *holes = (_leafy(ring, step) for ring in (floor.exterior, *floor.interiors))
    near, far = LANE / 2, (CELLS - 1) * (LANE + HEDGE) + LANE / 2
    # Two change places, so each ends beside where the other one starts.
    aside = 1.2 * RADIUS
    journeys: list[tuple[Point, Point]] = [
        ((near - aside, near - aside), (far - aside, far - aside)),
        ((far, near), (near, far)),
        ((far + aside, far + aside), (near + aside, near + aside)),
    ]
    plain = make_scene("maze", outer, [], journeys, horizon=SECONDS)
    return replace(
        plain,
        map=MapSpec(PolygonBase(outer, tuple(holes))),
        solver=replace(plain.solver, knots=knots),
    )


def maze_floor(rng: np.random.Generator) -> shapely.Polygon:
    """The lanes between the hedges of a random maze."""
    grid = nx.grid_2d_graph(CELLS, CELLS)
    ways = sorted(tuple(sorted(way)) for way in grid.edges)
    heights = rng.random(len(ways))
    for way, height in zip(ways, heights, strict=True):
        grid.edges[way]["weight"] = height
    tree = {tuple(sorted(way)) for way in nx.minimum_spanning_edges(grid, data=False)}
    closed = [way for way in ways if way not in tree]
    opened = rng.permutation(len(closed))[:LOOPS]
    open_ways = [*sorted(tree), *(closed[index] for index in opened)]
    boxes = [_box(cell, cell) for cell in sorted(grid.nodes)]
    boxes += [_box(*way) for way in open_ways]
    return orient(shapely.union_all(boxes).simplify(0.0))


def _box(a: tuple[int, int], b: tuple[int, int]) -> shapely.Polygon:
    """The floor of two neighbouring cells and of what lies between them."""
    pitch = LANE + HEDGE
    return shapely.box(pitch * a[0], pitch * a[1], pitch * b[0] + LANE, pitch * b[1] + LANE)


def _leafy(ring: shapely.LinearRing, step: float) -> tuple[Point, ...]:
    """`ring` with a vertex about every `step` m, its edges swinging away from the floor and back."""
    corners = shapely.get_coordinates(ring)
    points = []
    for start, end in pairwise(corners):
        length = float(np.hypot(*(end - start)))
        share = np.arange(max(round(length / step), 1)) / max(round(length / step), 1)
        swing = DEPTH / 2 * (1.0 - np.cos(2.0 * np.pi * round(length / WAVE) * share))
        # The floor lies to the left of the way from start to end.
        outwards = np.array([end[1] - start[1], start[0] - end[0]]) / length
        points.append(start + share[:, None] * (end - start) + swing[:, None] * outwards)
    return tuple((float(x), float(y)) for x, y in np.vstack(points))
