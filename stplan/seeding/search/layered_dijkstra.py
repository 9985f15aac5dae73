"""The cheapest way through the layers of space-time, around reserved rods or through them.

Every move leads one layer up, so settling the vertices layer by layer visits them in an order that
Dijkstra's queue would allow, without a queue. With a finite penalty the search passes
through reserved rods at a price, which is what the repair of neighbourhoods starts from.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.seeding.search.graph import UNREACHABLE, Graph, MoveRows
from stplan.seeding.search.journey import Journey, Window
from stplan.seeding.search.reservations import CountArray

HARD = np.inf


def cheapest_path(
    graph: Graph,
    journey: Journey,
    window: Window,
    table: CountArray,
    cost: FloatArray,
    penalty: float = HARD,
) -> IntArray | None:
    """Vertices at layers `window.first`, ... of the cheapest way through the layers, or None.

    Args:
        window: whose departure is not heeded.
        table: (M, L) counts of blocking rods.
        cost: (M,) cost of every move.
        penalty: cost of each blocking rod of a move; HARD forbids blocked moves.
    """
    path = _cheapest(journey, window, graph.leaving, table, cost, penalty)
    return path if len(path) else None


def space_time_length(graph: Graph, height: float) -> FloatArray:
    """(M,) length in space-time of every move of a layer `height` = c dt (m)."""
    return np.hypot(graph.length, height)


@inlined
def _price(count: int, penalty: float) -> float:
    """Cost of a move blocked by `count` rods."""
    return count * penalty if count > 0 else 0.0


@kernel
def _cheapest(
    journey: Journey,
    window: Window,
    leaving: MoveRows,
    table: CountArray,
    cost: FloatArray,
    penalty: float,
) -> IntArray:
    """The cheapest path, empty if there is none."""
    start, targets, hops, free = journey
    first_layer, last_layer = window.first, window.last
    num_layers = table.shape[1]
    num_legs, num_vertices = hops.shape
    nothing = np.empty(0, np.int64)
    leg = 0
    while leg < num_legs - 1 and start == targets[leg]:
        leg += 1
    if hops[leg, start] >= UNREACHABLE or last_layer < first_layer:
        return nothing
    goal = targets[num_legs - 1]
    final = (num_legs - 1) * num_vertices + goal
    # What staying on the goal from a layer on costs.
    tail = np.zeros(num_layers + 1)
    if window.stays:
        for layer in range(num_layers - 1, -1, -1):
            tail[layer] = tail[layer + 1] + _price(table[goal, layer], penalty)
    span = last_layer - first_layer
    parent = np.full((span + 1, num_legs * num_vertices), -1, np.int32)
    here = np.full(num_legs * num_vertices, np.inf)
    here[leg * num_vertices + start] = 0.0
    best = tail[first_layer] if leg * num_vertices + start == final else np.inf
    best_layer = 0
    cheapest_move = cost.min()
    for step in range(span):
        layer = first_layer + step
        after = np.full(num_legs * num_vertices, np.inf)
        for state in range(num_legs * num_vertices):
            if here[state] >= best:
                continue
            leg = state // num_vertices
            vertex = state - leg * num_vertices
            if here[state] + hops[leg, vertex] * cheapest_move >= best:
                continue
            # The wait is the move before the first walk.
            for place in range(leaving.offsets[vertex] - 1, leaving.offsets[vertex + 1]):
                move = vertex if place < leaving.offsets[vertex] else leaving.moves[place]
                if not free[move]:
                    continue
                other = leaving.ends[move]
                total = here[state] + cost[move] + _price(table[move, layer], penalty)
                next_leg = leg
                while next_leg < num_legs - 1 and other == targets[next_leg]:
                    next_leg += 1
                reached = next_leg * num_vertices + other
                if total >= after[reached] or layer + 1 + hops[next_leg, other] > last_layer:
                    continue
                after[reached] = total
                parent[step + 1, reached] = state
        here = after
        if here[final] + tail[layer + 1] < best:
            best = here[final] + tail[layer + 1]
            best_layer = step + 1
    if not np.isfinite(best):
        return nothing
    path = np.empty(best_layer + 1, np.int64)
    state = final if best_layer > 0 else start
    for step in range(best_layer, 0, -1):
        path[step] = state % num_vertices
        state = parent[step, state]
    path[0] = state % num_vertices
    return path
