"""The joint search of lattices against a breadth-first search of all configurations."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
import shapely

from stplan.arrays import IntArray
from stplan.seeding.search.graph import UNREACHABLE, Graph, make_graph
from stplan.seeding.search.joint_step import Company
from stplan.seeding.search.lacam import EXHAUSTED, FOUND, explore, new_memory, steps_found
from tests.seeding.search.puzzles import cells_of


def lattice(name: str) -> Graph:
    cells = cells_of(name)
    number = {cell: k for k, cell in enumerate(cells)}
    edges = [
        (k, number[x + dx, y + dy])
        for (x, y), k in number.items()
        for dx, dy in ((1, 0), (0, 1))
        if (x + dx, y + dy) in number
    ]
    return make_graph(
        np.array(cells, float), np.array(edges), np.full(len(cells) + len(edges), 1.0)
    )


def company(
    graph: Graph, start: IntArray, goal: IntArray, apart: float, *, following: bool = True
) -> Company:
    free = graph.free_moves(0.5)
    to_go = np.stack([graph.hops_to(int(end), free) for end in goal]).astype(float)
    to_go[to_go >= UNREACHABLE] = np.inf
    count = len(start)
    return Company(
        start, goal, to_go, np.tile(free, (count, 1)), np.full((count, count), apart),
        graph.vertices, graph.leaving, following,
    )  # fmt: skip


def gap(graph: Graph, a: tuple[int, int], b: tuple[int, int]) -> float:
    """Least distance of two that move at once, sampled at the only place where it can be."""
    head = graph.vertices[a[0]] - graph.vertices[b[0]]
    step = graph.vertices[a[1]] - graph.vertices[b[1]] - head
    share = np.clip(-(head @ step) / max(float(step @ step), 1e-300), 0.0, 1.0)
    return float(np.hypot(*(head + share * step)))


def reachable(graph: Graph, start: tuple[int, ...], apart: float) -> set[tuple[int, ...]]:
    """All configurations that can be reached."""
    near = {v: [v] for v in range(graph.num_vertices)}
    for a, b in graph.edges.tolist():
        near[a].append(b)
        near[b].append(a)
    known, todo = {start}, [start]
    while todo:
        here = todo.pop()
        for after in product(*(near[v] for v in here)):
            moves = list(zip(here, after, strict=True))
            if after not in known and all(
                gap(graph, moves[a], moves[b]) > apart for a in range(len(moves)) for b in range(a)
            ):
                known.add(after)
                todo.append(after)
    return known


@pytest.mark.parametrize("name", ["string", "tunnel", "connector"])
@pytest.mark.parametrize("apart", [0.6, 0.9])
def test_what_can_be_reached_is_found_and_what_cannot_is_exhausted(name: str, apart: float) -> None:
    graph = lattice(name)
    rng = np.random.default_rng(3)
    start = rng.permutation(graph.num_vertices)[:3]
    known = reachable(graph, tuple(start.tolist()), apart)
    goals = [rng.permutation(graph.num_vertices)[:3] for _ in range(25)]
    ends = [tuple(goal.tolist()) in known for goal in goals]
    assert any(ends)
    for goal, is_reachable in zip(goals, ends, strict=True):
        memory = new_memory(company(graph, start, goal, apart), 1)
        status = explore(company(graph, start, goal, apart), memory, 500_000)
        assert status == (FOUND if is_reachable else EXHAUSTED)
        if status == FOUND:
            steps = steps_found(memory)
            assert np.array_equal(steps[[0, -1]], [start, goal])
            assert all(tuple(row) in known for row in steps.tolist())


def test_steps_keep_everybody_apart() -> None:
    graph = lattice("loop-chain")
    rng = np.random.default_rng(0)
    start = rng.permutation(graph.num_vertices)[:7]
    goal = rng.permutation(start)
    own = company(graph, start, goal, 0.9)
    memory = new_memory(own, 0)
    assert explore(own, memory, 500_000) == FOUND
    steps = steps_found(memory)
    edges = [set(edge) for edge in graph.edges.tolist()]
    for here, after in pairwise(steps):
        moves = list(zip(here.tolist(), after.tolist(), strict=True))
        assert all(gap(graph, moves[a], moves[b]) > 0.9 for a in range(7) for b in range(a))
        assert all(a == b or {a, b} in edges for a, b in moves)


def test_where_nobody_may_follow_at_once_all_that_is_passed_is_kept_clear() -> None:
    graph = lattice("loop-chain")
    start, goal = np.array([0, 1, 2]), np.array([8, 7, 6])
    own = company(graph, start, goal, 0.6, following=False)
    memory = new_memory(own, 0)
    assert explore(own, memory, 500_000) == FOUND
    steps = steps_found(memory)
    assert np.array_equal(steps[-1], goal)
    for here, after in pairwise(graph.vertices[steps]):
        lines = shapely.linestrings(np.stack([here, after], axis=1))
        assert all(shapely.distance(lines[a], lines[b]) > 0.6 for a in range(3) for b in range(a))


def test_two_in_a_lane_cannot_change_places() -> None:
    line = np.column_stack([np.arange(5.0), np.zeros(5)])
    edges = np.column_stack([np.arange(4), np.arange(1, 5)])
    graph = make_graph(line, edges, np.full(9, 1.0))
    own = company(graph, np.array([1, 3]), np.array([3, 1]), 0.6)
    assert explore(own, new_memory(own, 0), 100_000) == EXHAUSTED
