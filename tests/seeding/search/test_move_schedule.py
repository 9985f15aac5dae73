"""Steps become curves: no needless moves, everybody as early as can be, in the order of the steps."""

from __future__ import annotations

import numpy as np

from stplan.seeding.search.graph import Graph, make_graph
from stplan.seeding.search.move_schedule import (
    begins,
    moves_of,
    scheduled_curves,
    without_loops,
)


def lane(count: int) -> Graph:
    line = np.column_stack([np.arange(float(count)), np.zeros(count)])
    edges = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    return make_graph(line, edges, np.full(2 * count - 1, 1.0))


def apart(count: int, distance: float) -> np.ndarray:
    return np.full((count, count), distance)


def test_moves_there_and_back_are_waited_out() -> None:
    steps = np.array([[0, 4], [1, 5], [2, 4], [3, 5], [3, 4], [3, 5]])
    kept = without_loops(lane(6), steps, apart(2, 0.6))
    assert (np.diff(kept, axis=0) != 0).sum(axis=0).tolist() == [3, 1]
    assert np.array_equal(kept[[0, -1]], steps[[0, -1]])


def test_moves_that_make_room_are_kept() -> None:
    graph = make_graph(
        np.array([[0.0, 0], [1, 0], [2, 0], [1, 1]]),
        np.array([[0, 1], [1, 2], [1, 3]]),
        np.full(7, 1.0),
    )
    steps = np.array([[0, 1], [0, 3], [1, 3], [2, 3], [2, 1]])
    assert np.array_equal(without_loops(graph, steps, apart(2, 0.6)), steps)


def test_followers_wait_for_the_place_and_others_do_not() -> None:
    graph = lane(9)
    steps = np.array([[0, 1, 7], [1, 2, 7], [2, 3, 7], [2, 3, 8]])
    moves = moves_of(steps)
    times = begins(graph, moves, apart(3, 0.6))
    assert times is not None
    # The one ahead goes at once; its follower a length later; the third waits for nobody.
    order = {
        (int(a), int(h)): float(t)
        for a, h, t in zip(moves.agent, moves.head, times[0], strict=True)
    }
    assert order == {(0, 1): 1.0, (1, 2): 0.0, (0, 2): 2.0, (1, 3): 1.0, (2, 8): 0.0}


def test_a_ring_that_turns_at_once_has_no_order() -> None:
    square = make_graph(
        np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]),
        np.array([[0, 1], [1, 2], [2, 3], [3, 0]]),
        np.full(8, 1.0),
    )
    steps = np.array([[0, 1, 2, 3], [1, 2, 3, 0]])
    assert scheduled_curves(square, steps, apart(4, 0.6), 0.0, 10.0) is None


def test_curves_use_all_the_time_and_keep_their_ends() -> None:
    steps = np.array([[0, 2], [1, 3], [2, 4], [2, 4]])
    curves = scheduled_curves(lane(5), steps, apart(2, 0.6), 3.0, 18.0)
    assert curves is not None
    assert [tuple(curve[0]) for curve in curves] == [(0.0, 0.0, 3.0), (2.0, 0.0, 3.0)]
    assert max(float(curve[-1, 2]) for curve in curves) == 18.0
    assert all((np.diff(curve[:, 2]) > 0).all() for curve in curves)
