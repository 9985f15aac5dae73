"""Reservations and the two single-agent searches against brute force."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import Delaunay

from stplan.seeding.search.graph import UNREACHABLE, Graph, make_graph
from stplan.seeding.search.journey import Journey, Window
from stplan.seeding.search.layered_dijkstra import HARD, cheapest_path
from stplan.seeding.search.reservations import Reservations, TimeGrid
from stplan.seeding.search.safe_interval import SafeIntervalSearch
from stplan.seeding.search.soft_interval import SoftIntervalSearch
from tests.geometry.points import apart_squared

LAYERS = 24


def random_graph(rng: np.random.Generator, count: int = 30) -> Graph:
    vertices = rng.uniform(0, 6, (count, 2))
    triangles = Delaunay(vertices).simplices
    pairs = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]])
    edges = np.unique(np.sort(pairs, axis=1), axis=0)
    return make_graph(vertices, edges, np.full(len(vertices) + len(edges), np.inf))


def random_rod(rng: np.random.Generator) -> np.ndarray:
    heights = np.sort(rng.uniform(0, 9, 5))
    rod = np.column_stack([rng.uniform(0, 6, (5, 2)), heights])
    rod[2, :2] = rod[1, :2]
    return rod


@pytest.mark.parametrize("seed", range(4))
def test_blocks_are_exactly_the_moves_that_come_too_near(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph = random_graph(rng)
    grid = TimeGrid(begin=0.5, step=0.4, count=LAYERS, time_scale=1.25)
    reservations = Reservations(graph, grid, 1)
    rod, distance = random_rod(rng), 0.8
    found = np.zeros((graph.num_moves, LAYERS), dtype=bool)
    for move, low, high in reservations.blocks(rod, distance):
        found[move, low : high + 1] = True
    base = grid.begin * grid.time_scale
    for move in range(graph.num_moves):
        u, v = graph.vertices[graph.move_from[move]], graph.vertices[graph.move_to[move]]
        for layer in range(LAYERS):
            p = np.array([*u, base + layer * grid.height])
            q = np.array([*v, base + (layer + 1) * grid.height])
            gap = min(apart_squared(p, q, rod[k], rod[k + 1]) for k in range(len(rod) - 1))
            assert found[move, layer] == (gap <= (distance * (1 + 4e-9)) ** 2)


def test_reservations_can_be_taken_back() -> None:
    rng = np.random.default_rng(7)
    graph = random_graph(rng)
    reservations = Reservations(graph, TimeGrid(0.0, 0.4, LAYERS, 1.0), 2)
    blocks = [reservations.blocks(random_rod(rng), 0.9) for _ in range(3)]
    for found in blocks:
        assert len(found) > 0
        reservations.add(1, found)
    assert reservations.tables[1].max() >= 1
    for found in blocks:
        reservations.remove(1, found)
    assert reservations.tables[1].max() == 0
    assert reservations.tables[0].max() == 0


def numbered_moves(graph: Graph) -> dict[tuple[int, int], int]:
    ends = zip(graph.move_from.tolist(), graph.move_to.tolist(), strict=True)
    return {pair: move for move, pair in enumerate(ends)}


def earliest(
    graph: Graph, start: int, goal: int, table: np.ndarray, first: int, departure: int, stays: bool
) -> int:
    """Earliest arrival layer by visiting every vertex at every layer, -1 if there is none."""
    here = {start}
    for layer in range(first, LAYERS + 1):
        tail_is_free = not stays or not table[goal, layer:].any()
        if goal in here and tail_is_free and layer >= departure:
            return layer
        if layer == LAYERS:
            break
        after = set()
        for move in range(graph.num_moves):
            waits = move < graph.num_vertices
            allowed = not table[move, layer] and (layer >= departure or waits)
            if graph.move_from[move] in here and allowed:
                after.add(int(graph.move_to[move]))
        here = after
    return -1


@pytest.mark.parametrize("seed", range(12))
def test_safe_intervals_arrive_as_early_as_possible(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph = random_graph(rng, 14)
    table = (rng.random((graph.num_moves, LAYERS)) < 0.45).astype(np.uint16)
    table[:, LAYERS - 6 :] &= (rng.random((graph.num_moves, 6)) < 0.1).astype(np.uint16)
    stays, first, departure = bool(seed % 2), seed % 3, 2 * (seed % 2) + seed % 3
    start, goal = 0, 1
    free = np.ones(graph.num_moves, dtype=bool)
    targets = np.array([goal])
    hops = graph.hops_to(goal, free)[None]
    search = SafeIntervalSearch(graph)
    path = search.path(
        Journey(start, targets, hops, free), Window(first, LAYERS, stays, departure), table
    )
    expected = earliest(graph, start, goal, table, first, departure, stays)
    if path is None:
        assert expected == -1
        return
    assert first + len(path) - 1 == expected
    moves = numbered_moves(graph)
    for step, pair in enumerate(pairwise(path.tolist())):
        assert table[moves[pair], first + step] == 0


def two_legs(graph: Graph, targets: np.ndarray, free: np.ndarray) -> np.ndarray:
    """(2, V) hops to go through the first target to the second."""
    second = graph.hops_to(int(targets[1]), free)
    first = graph.hops_to(int(targets[0]), free) + second[targets[0]]
    return np.stack([first, second])


def test_waypoints_are_passed_in_order() -> None:
    rng = np.random.default_rng(3)
    graph = random_graph(rng)
    free = np.ones(graph.num_moves, dtype=bool)
    targets = np.array([5, 9])
    hops = two_legs(graph, targets, free)
    table = np.zeros((graph.num_moves, LAYERS), dtype=np.uint16)
    journey, window = Journey(9, targets, hops, free), Window(0, LAYERS, True)
    path = SafeIntervalSearch(graph).path(journey, window, table)
    assert path is not None
    assert len(path) - 1 == hops[0, 9]
    assert path[0] == path[-1] == 9
    assert 5 in path
    cost = np.hypot(graph.length, 0.5)
    cheap = cheapest_path(graph, journey, window, table, cost)
    assert cheap is not None
    assert cheap[0] == cheap[-1] == 9
    assert 5 in cheap


def cheapest(graph: Graph, goal: int, table: np.ndarray, cost: np.ndarray, penalty: float) -> float:
    """Least cost from vertex 0 at layer 0 by relaxing every move of every layer, staying after."""
    here = np.full(graph.num_vertices, np.inf)
    here[0] = 0.0
    best = np.inf
    for layer in range(LAYERS + 1):
        blocked = table[goal, layer:].sum()
        best = min(best, here[goal] + (blocked * penalty if blocked else 0.0))
        if layer == LAYERS:
            break
        after = np.full(graph.num_vertices, np.inf)
        for move in range(graph.num_moves):
            count = table[move, layer]
            total = here[graph.move_from[move]] + cost[move] + (count * penalty if count else 0.0)
            after[graph.move_to[move]] = min(after[graph.move_to[move]], total)
        here = after
    return float(best)


@pytest.mark.parametrize("penalty", [HARD, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_cheapest_path_is_cheapest(seed: int, penalty: float) -> None:
    rng = np.random.default_rng(seed)
    graph = random_graph(rng, 14)
    table = (rng.random((graph.num_moves, LAYERS)) < 0.4).astype(np.uint16)
    table[1, LAYERS - 4 :] = 0
    free = np.ones(graph.num_moves, dtype=bool)
    cost = np.hypot(graph.length, 0.5)
    journey = Journey(0, np.array([1]), graph.hops_to(1, free)[None], free)
    path = cheapest_path(graph, journey, Window(0, LAYERS, True), table, cost, penalty)
    expected = cheapest(graph, 1, table, cost, penalty)
    if path is None:
        assert np.isinf(expected)
        return
    moves = numbered_moves(graph)
    total = 0.0
    for layer, pair in enumerate(pairwise(path.tolist())):
        count = table[moves[pair], layer]
        total += cost[moves[pair]] + (count * penalty if count else 0.0)
    blocked = table[1, len(path) - 1 :].sum()
    total += blocked * penalty if blocked else 0.0
    assert total == pytest.approx(expected)


def rods_that_come(now: int, before: int) -> int:
    return max(int(now) - int(before), 0)


def level_of(table: np.ndarray, vertex: int, instant: int) -> int:
    """Rods around one who has just come to a vertex: those of the freer of the two layers that meet there."""
    around = table[vertex, max(instant - 1, 0) : instant + 1]
    return int(around.min())


def fewest_rods(graph: Graph, goal: int, table: np.ndarray, penalty: int) -> float:
    """Least arrival plus penalties from vertex 0 by all moves of every layer, staying after."""
    here = {(0, int(table[0, 0])): int(table[0, 0])}
    best = np.inf
    for layer in range(LAYERS + 1):
        after: dict[tuple[int, int], int] = {}
        for (vertex, level), touched in here.items():
            if vertex == goal:
                waits = [level, *table[goal, layer:].tolist()]
                tail = sum(rods_that_come(b, a) for a, b in pairwise(waits))
                best = min(best, layer + penalty * (touched + tail))
            for move in range(graph.num_moves) if layer < LAYERS else ():
                if graph.move_from[move] != vertex:
                    continue
                other, count = int(graph.move_to[move]), int(table[move, layer])
                there = count if other == vertex else level_of(table, other, layer + 1)
                total = touched + rods_that_come(count, level) + rods_that_come(there, count)
                key = (other, there)
                after[key] = min(after.get(key, total), total)
        here = after
    return best


@pytest.mark.parametrize("penalty", [1, 3, 1000])
@pytest.mark.parametrize("seed", range(3))
def test_the_soft_search_touches_as_few_rods_as_can_be(seed: int, penalty: int) -> None:
    rng = np.random.default_rng(seed)
    graph = random_graph(rng, 12)
    table = rng.integers(0, 3, (graph.num_moves, LAYERS // 2)).astype(np.uint16).repeat(2, axis=1)
    free = np.ones(graph.num_moves, dtype=bool)
    journey = Journey(0, np.array([1]), graph.hops_to(1, free)[None], free)
    path = SoftIntervalSearch(graph).path(journey, Window(0, LAYERS, True), table, penalty)
    assert path is not None
    moves = numbered_moves(graph)
    level = touched = int(table[0, 0])
    for layer, (tail, head) in enumerate(pairwise(path.tolist())):
        count = int(table[moves[tail, head], layer])
        there = count if tail == head else level_of(table, head, layer + 1)
        touched += rods_that_come(count, level) + rods_that_come(there, count)
        level = there
    waits = [level, *table[1, len(path) - 1 :].tolist()]
    touched += sum(rods_that_come(b, a) for a, b in pairwise(waits))
    assert path[-1] == 1
    assert len(path) - 1 + penalty * touched == fewest_rods(graph, 1, table, penalty)


def test_the_soft_search_passes_waypoints_in_order_and_nobody_where_it_can() -> None:
    rng = np.random.default_rng(3)
    graph = random_graph(rng)
    free = np.ones(graph.num_moves, dtype=bool)
    targets = np.array([5, 9])
    hops = two_legs(graph, targets, free)
    table = (rng.random((graph.num_moves, LAYERS)) < 0.1).astype(np.uint16)
    table[9] = 0
    journey, window = Journey(9, targets, hops, free), Window(0, LAYERS, True)
    soonest = SafeIntervalSearch(graph).path(journey, window, table)
    path = SoftIntervalSearch(graph).path(journey, window, table, 1000)
    assert soonest is not None
    assert path is not None
    assert len(path) == len(soonest)
    moves = numbered_moves(graph)
    assert not any(table[moves[pair], layer] for layer, pair in enumerate(pairwise(path.tolist())))
    assert path[0] == path[-1] == 9
    assert 5 in path


def test_unreachable_goals_have_no_path() -> None:
    graph = make_graph(np.array([[0.0, 0.0], [1.0, 0.0]]), np.empty((0, 2), dtype=int), np.ones(2))
    free = graph.free_moves(0.5)
    hops = graph.hops_to(1, free)[None]
    assert hops[0, 0] == UNREACHABLE
    path = SafeIntervalSearch(graph).path(
        Journey(0, np.array([1]), hops, free), Window(0, 4, False), np.zeros((2, 4), np.uint16)
    )
    assert path is None
