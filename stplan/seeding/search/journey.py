"""Where an agent has to go on a graph, and between which layers of time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.seeding.search.graph import MoveRows


class Journey(NamedTuple):
    """Where to go, whatever the layers.

    Attributes:
        start: vertex.
        targets: (P,) vertices to reach in order, the goal last: leg p ends at target p.
        hops: (P, V) fewest hops to the goal on leg p, UNREACHABLE where there is no way.
        free: (M,) moves clear of the walls.
    """

    start: int
    targets: IntArray
    hops: IntArray
    free: BoolArray


class Window(NamedTuple):
    """When to be there.

    Attributes:
        first, last: layer at the start, and latest layer of arrival.
        stays: the goal must be free from arrival to the last layer of the table.
        departure: the start is not left before this layer.
    """

    first: int
    last: int
    stays: bool
    departure: int = 0


@inlined
def leg_at(vertex: int, leg: int, targets: IntArray) -> int:
    """The leg that goes on from a vertex reached on `leg`: a later one if targets are there."""
    while leg < len(targets) - 1 and vertex == targets[leg]:
        leg += 1
    return leg


@kernel
def shortest_way(journey: Journey, leaving: MoveRows) -> IntArray:
    """Vertices of one way of fewest hops through all targets of a journey that can be made."""
    hops, targets = journey.hops, journey.targets
    vertex = journey.start
    way = np.empty(hops[0, vertex] + 1, np.int64)
    way[0] = vertex
    leg = 0
    for step in range(1, len(way)):
        leg = leg_at(vertex, leg, targets)
        for place in range(leaving.offsets[vertex], leaving.offsets[vertex + 1]):
            move = leaving.moves[place]
            if journey.free[move] and hops[leg, leaving.ends[move]] < hops[leg, vertex]:
                vertex = leaving.ends[move]
                break
        way[step] = vertex
    return way
