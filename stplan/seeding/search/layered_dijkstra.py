"""The cheapest way through the layers of space-time, around reserved rods or through them.

Every move leads one layer up, so settling the vertices layer by layer visits them in an order that
Dijkstra's queue would allow, without a queue. With a finite penalty the search passes
through reserved rods at a price, which is what the repair of neighbourhoods starts from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inlined, kernel
from stplan.deadline import passed
from stplan.seeding.search.graph import UNREACHABLE, Graph, MoveRows
from stplan.seeding.search.journey import Journey, Window, leg_at
from stplan.seeding.search.reservations import CountArray

StateArray = NDArray[np.int32]

HARD = np.inf
# The clock is looked at every so many vertices of layers.
CHUNK = 500_000


def cheapest_path(
    graph: Graph,
    journey: Journey,
    window: Window,
    table: CountArray,
    cost: FloatArray,
    penalty: float = HARD,
) -> IntArray | None:
    """Vertices at layers `window.first`, ... of the cheapest way through the layers, or None.

    None where there is none, and where the deadline passes before it is found.

    Args:
        window: whose departure is not heeded.
        table: (M, L) counts of blocking rods.
        cost: (M,) cost of every move.
        penalty: cost of each blocking rod of a move; HARD forbids blocked moves.
    """
    num_legs, num_vertices = journey.hops.shape
    leg = _first_leg(journey)
    if journey.hops[leg, journey.start] >= UNREACHABLE or window.last < window.first:
        return None
    span = window.last - window.first
    labels = _new_labels(journey, window, table, penalty, leg)
    layers = max(1, CHUNK // (num_legs * num_vertices))
    for first in range(0, span, layers):
        steps = (first, min(first + layers, span))
        _settle(journey, window, graph.leaving, table, cost, penalty, labels, steps)
        if passed():
            return None
    return _way_back(journey, labels) if np.isfinite(labels.best[0]) else None


class _Labels(NamedTuple):
    """What is known of the S = P V states, a vertex on a leg each, up to some layer.

    Attributes:
        here: (S,) least cost to be in a state at that layer.
        parent: (T, S) the state before at every layer from the first one on.
        tail: (L + 1,) what staying on the goal from a layer on costs.
        best: (1,) cost of the cheapest way that has reached the goal.
        arrival: (1,) its steps.
    """

    here: FloatArray
    parent: StateArray
    tail: FloatArray
    best: FloatArray
    arrival: IntArray


def _first_leg(journey: Journey) -> int:
    """The leg an agent is on that has not moved yet."""
    leg = 0
    while leg < len(journey.targets) - 1 and journey.start == journey.targets[leg]:
        leg += 1
    return leg


def _new_labels(
    journey: Journey, window: Window, table: CountArray, penalty: float, leg: int
) -> _Labels:
    """Labels of the first layer: at the start, on a leg."""
    num_legs, num_vertices = journey.hops.shape
    goal, num_states = int(journey.targets[-1]), num_legs * num_vertices
    start = leg * num_vertices + journey.start
    here = np.full(num_states, np.inf)
    here[start] = 0.0
    tail = np.zeros(table.shape[1] + 1)
    if window.stays:
        _fill_tail(tail, table[goal], penalty)
    at_goal = start == (num_legs - 1) * num_vertices + goal
    best = tail[window.first] if at_goal else np.inf
    parent = np.full((window.last - window.first + 1, num_states), -1, np.int32)
    return _Labels(here, parent, tail, np.array([best]), np.zeros(1, np.int64))


def space_time_length(graph: Graph, height: float) -> FloatArray:
    """(M,) length in space-time of every move of a layer `height` = c dt (m)."""
    return np.hypot(graph.length, height)


@inlined
def _price(count: int, penalty: float) -> float:
    """Cost of a move blocked by `count` rods."""
    return count * penalty if count > 0 else 0.0


@kernel
def _fill_tail(tail: FloatArray, counts: CountArray, penalty: float) -> None:
    """Fill `tail` (L + 1,) from how often the goal is blocked on every layer."""
    for layer in range(len(counts) - 1, -1, -1):
        tail[layer] = tail[layer + 1] + _price(counts[layer], penalty)


@kernel
def _settle(
    journey: Journey, window: Window, leaving: MoveRows, table: CountArray, cost: FloatArray,
    penalty: float, labels: _Labels, steps: tuple[int, int],
) -> None:  # fmt: skip
    """Go on by the `steps` from one to before the other; `table` (M, L)."""
    targets, hops, free = journey.targets, journey.hops, journey.free
    first_layer, last_layer = window.first, window.last
    num_legs, num_vertices = hops.shape
    final = (num_legs - 1) * num_vertices + targets[num_legs - 1]
    cheapest_move = cost.min()
    here, parent, tail = labels.here, labels.parent, labels.tail
    best = labels.best[0]
    after = np.empty(num_legs * num_vertices)
    for step in range(steps[0], steps[1]):
        layer = first_layer + step
        after[:] = np.inf
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
                next_leg = leg_at(other, leg, targets)
                reached = next_leg * num_vertices + other
                if total >= after[reached] or layer + 1 + hops[next_leg, other] > last_layer:
                    continue
                after[reached] = total
                parent[step + 1, reached] = state
        here[:] = after
        if here[final] + tail[layer + 1] < best:
            best = here[final] + tail[layer + 1]
            labels.arrival[0] = step + 1
    labels.best[0] = best


@kernel
def _way_back(journey: Journey, labels: _Labels) -> IntArray:
    """Vertices of the cheapest way."""
    num_legs, num_vertices = journey.hops.shape
    steps = labels.arrival[0]
    path = np.empty(steps + 1, np.int64)
    state = (num_legs - 1) * num_vertices + journey.targets[num_legs - 1]
    for step in range(steps, 0, -1):
        path[step] = state % num_vertices
        state = labels.parent[step, state]
    path[0] = state % num_vertices
    return path
