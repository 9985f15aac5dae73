"""Small puzzles of discrete path finding as scenes: rooms of unit cells, in which agents change places."""

from __future__ import annotations

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.scene.model import Scene
from tests.seeding import tight_families as families

# Cells that are free, row by row from the top.
ROOMS = {
    "tunnel": ["o", "o", "o", "o", "oooo", "o"],
    "string": ["ooooooo", " o o o "],
    "tree": ["  o  ", " ooo ", "  o  ", " ooo ", "oo oo"],
    "corners": ["oooo", "oooo", "oooo", "oooo"],
    "connector": ["  o  ", "ooooo", "  o  "],
    "loop-chain": ["ooo ooo ooo", "o ooo ooo o", "ooo ooo ooo"],
}
AGENTS = {"loop-chain": 7}


def cells_of(name: str) -> list[tuple[int, int]]:
    """Lower left corners of a room's cells."""
    return [
        (x, -y) for y, row in enumerate(ROOMS[name]) for x, cell in enumerate(row) if cell == "o"
    ]


def puzzle(name: str, rng_seed: int, radius: float, agents: int = 0) -> Scene:
    """Agents on random cells of a room, each bound for the cell of another."""
    middles = np.array(cells_of(name)) + 0.5
    rng = np.random.default_rng(rng_seed)
    starts = rng.permutation(len(middles))[: agents or AGENTS.get(name, 4)]
    goals = rng.permutation(starts)
    return _scene(name, list(zip(middles[starts], middles[goals], strict=True)), radius)


def reversal(radius: float) -> Scene:
    """Four agents in a tunnel have to end in reverse order; there is one pocket."""
    starts = [np.array([0.5, 0.5 - y]) for y in (0, 1, 2, 4)]
    goals = [np.array([0.5, 0.5 - y]) for y in (3, 2, 1, 0)]
    return _scene("tunnel", list(zip(starts, goals, strict=True)), radius)


def _scene(name: str, ends: list[tuple[FloatArray, FloatArray]], radius: float) -> Scene:
    cells = np.array(cells_of(name))
    floor = shapely.union_all(shapely.box(*cells.T, *(cells.T + 1)))
    outer, *holes = (
        tuple((x, y) for x, y in shapely.get_coordinates(ring)[:-1].tolist())
        for ring in (floor.exterior, *floor.interiors)
    )
    journeys = [(tuple(start.tolist()), tuple(goal.tolist())) for start, goal in ends]
    return families.make_scene(name, outer, holes, journeys, radii=radius)
