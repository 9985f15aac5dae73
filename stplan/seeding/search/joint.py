"""Joint search of two or three agents that block each other in every order.

A state is the vertices of all agents of the group at once; a step moves each along one free edge or
lets it wait. Whatever detours a swap takes (back into a pocket, past it, and out again) it is
found if the roadmap has it. Steps have no time of their own: bodies that keep
D = R sqrt(1 + v^2 / c^2) at equal times have rods further apart than R, v being the speed of a step.
The steps share all the time there is, and stretching never lowers a rod distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.callbacks import Stop
from stplan.compiled import inlined, kernel
from stplan.deadline import passed
from stplan.geometry.growable import with_room
from stplan.problem.clearance import rod_clearances
from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.search.graph import UNREACHABLE, Graph
from stplan.seeding.search.heap import drop_root, push
from stplan.seeding.search.planner import LayeredPlanner

StepArray = NDArray[np.int32]

MOST_AGENTS = 3
# More joint states than this are not searched.
MOST_STATES = 40_000_000
MOST_EXPANSIONS = 200_000
# The clock is looked at every so many moves of agents that are tried.
CHUNK = 500_000
# Distances kept at equal times, in required distances, smallest first.
WIDENINGS = (1.0, 1.03, 1.1, 1.2, 1.4)
ORDERS_OF_OTHERS = 6


@dataclass(frozen=True)
class Joint:
    """What a joint search found.

    Attributes:
        curves: one (n, 3) curve an agent, or None.
        impossible: the group has no way past each other on this roadmap, however it moves, so
            nor has the whole scene.
    """

    curves: list[FloatArray] | None
    impossible: bool = False


def plan_jointly(
    planner: LayeredPlanner,
    group: Sequence[int],
    rng: np.random.Generator,
    stopped: Stop,
) -> Joint:
    """Curves of all agents, the `group` (2 or 3) planned first and jointly."""
    for widening in WIDENINGS:
        if stopped():
            break
        steps, exhausted = _joint_steps(planner, group, widening)
        if steps is None:
            # Wider distances leave even fewer ways. Rods further apart than R are so at equal
            # times: without widening, no way is a proof if all are there from start to end.
            problem = planner.problem
            together = len(np.unique(problem.start_times[list(group)])) == 1
            stay = bool(problem.stays[list(group)].all())
            return Joint(None, exhausted and widening == WIDENINGS[0] and together and stay)
        curves = _with_others(
            planner, group, timed_curves(planner.problem, planner.graph, group, steps), rng
        )
        if curves is not None:
            return Joint(curves)
    return Joint(None)


def _joint_steps(
    planner: LayeredPlanner, group: Sequence[int], widening: float
) -> tuple[IntArray | None, bool]:
    """(n + 1, G) vertices of the group after every step, or None; and whether all was searched."""
    journeys, graph = planner.journeys, planner.graph
    size = len(group)
    legs = [len(journeys.targets[agent]) for agent in group]
    if not 2 <= size <= MOST_AGENTS or max(legs) > 1 or graph.num_vertices**size > MOST_STATES:
        return None, False
    apart = np.zeros((size, size))
    for i, a in enumerate(group):
        for j, b in enumerate(group):
            if planner.problem.collides[a, b]:
                apart[i, j] = planner.required.rods[a, b] * widening
    start = np.array([journeys.start[agent] for agent in group], dtype=np.int64)
    goal = np.array([journeys.targets[agent][-1] for agent in group], dtype=np.int64)
    # Ends may be nearer than a widened distance: they are what they are.
    for ends in (start, goal):
        step = graph.vertices[ends][:, None] - graph.vertices[ends][None]
        gap = np.hypot(step[..., 0], step[..., 1]) + np.diag(np.full(size, np.inf))
        apart = np.minimum(apart, gap * (1.0 - 1e-9))
    members = Group(
        start, goal,
        np.stack([journeys.hops[agent][0] for agent in group]),
        np.stack([journeys.free[agent] for agent in group]),
        apart,
    )  # fmt: skip
    return _searched(members, graph)


def _searched(group: Group, graph: Graph) -> tuple[IntArray | None, bool]:
    """(n + 1, G) vertices, None where none were found; and whether all that can be reached was searched."""
    size, num_states = len(group.start), graph.num_vertices ** len(group.start)
    if (group.hops[np.arange(size), group.start] >= UNREACHABLE).any():
        return None, True
    front = Front(
        np.full(num_states, -1, np.int64),
        np.full(num_states, 1 << 30, np.int32),
        np.empty((1 << 16, 3), np.int64),
        np.zeros(2, np.int64),
    )
    _begin(group, graph.num_vertices, front)
    while front.counts[0] > 0 and front.counts[1] < MOST_EXPANSIONS:
        final, heap = _search(group, graph, front, MOST_EXPANSIONS, CHUNK)
        front = front._replace(heap=heap)
        if final >= 0:
            steps = _walk_back(final, size, graph.num_vertices, front)
            return (steps if len(steps) > 1 else None), False
        if passed():
            return None, False
    return None, bool(front.counts[0] == 0)


def timed_curves(
    problem: PlanningProblem, graph: Graph, group: Sequence[int], steps: IntArray
) -> dict[int, FloatArray]:
    """Curves of the group from its vertices after every step (n + 1, G), over the time that all of it has."""
    begin = max(float(problem.start_times[agent]) for agent in group)
    end = min(float(problem.max_times[agent]) for agent in group)
    times = np.linspace(begin, end, len(steps))
    curves = {}
    for column, agent in enumerate(group):
        path = steps[:, column]
        arrival = max(int(np.flatnonzero(path != path[-1]).max(initial=0)) + 1, 1)
        knots = np.column_stack([graph.vertices[path], times])[: arrival + 1]
        path = path[: arrival + 1]
        kept = np.ones(len(path), dtype=bool)
        kept[1:-1] = (path[1:-1] != path[:-2]) | (path[1:-1] != path[2:])
        knots = knots[kept]
        if problem.start_times[agent] < begin:
            first = [*problem.starts[agent], problem.start_times[agent]]
            knots = np.vstack([[first], knots])
        knots[0, :2] = problem.starts[agent]
        knots[-1, :2] = problem.goals[agent]
        curves[agent] = np.ascontiguousarray(knots)
    return curves


def _with_others(
    planner: LayeredPlanner,
    group: Sequence[int],
    curves: dict[int, FloatArray],
    rng: np.random.Generator,
) -> list[FloatArray] | None:
    """All curves, everybody else planned around the group; None if the group's rods touch."""
    others = [agent for agent in planner.movers if agent not in curves]
    others.sort(key=lambda agent: -int(planner.journeys.distance[agent]))
    for _ in range(ORDERS_OF_OTHERS if others else 1):
        planner.reset()
        found = [path if path is not None else np.empty((0, 3)) for path in planner.problem.paths]
        for agent in group:
            found[agent] = curves[agent]
            planner.add(planner.blocks(agent, curves[agent]))
        complete = True
        for agent in others:
            path = planner.path(agent)
            if path is None:
                complete = False
                break
            found[agent] = planner.curve(agent, path)
            planner.add(planner.blocks(agent, found[agent]))
        if complete:
            clear = rod_clearances(planner.problem, found, planner.required.rods, reach=1.01)
            return None if clear.violations else found
        others = [int(agent) for agent in rng.permutation(np.array(others))]
    return None


class Group(NamedTuple):
    """G agents whose moves are searched at once.

    Attributes:
        start, goal: (G,) vertices.
        hops: (G, V) fewest hops to the goal.
        free: (G, M) moves clear of the walls.
        apart: (G, G) distances kept, m.
    """

    start: IntArray
    goal: IntArray
    hops: IntArray
    free: BoolArray
    apart: FloatArray


@inlined
def _least_gap(x0: float, y0: float, x1: float, y1: float) -> float:
    """Least squared length of a difference that moves straight from (x0, y0) to (x1, y1)."""
    dx = x1 - x0
    dy = y1 - y0
    square = dx * dx + dy * dy
    share = 0.0
    if square > 0.0:
        share = min(max(-(x0 * dx + y0 * dy) / square, 0.0), 1.0)
    x = x0 + share * dx
    y = y0 + share * dy
    return x * x + y * y


class Front(NamedTuple):
    """How far a search has come over the V^G joint states.

    Attributes:
        parent: the state before, -1 without any.
        steps: fewest steps to each state known so far.
        heap: queue of states.
        counts: entries of the queue, and states expanded.
    """

    parent: IntArray
    steps: StepArray
    heap: IntArray
    counts: IntArray


@inlined
def _code(places: IntArray, num_vertices: int) -> int:
    """The number of the state in which agents are at `places` (G,)."""
    code = 0
    for agent in range(len(places)):
        code = code * num_vertices + places[agent]
    return code


@kernel
def _begin(group: Group, num_vertices: int, front: Front) -> None:
    """Enter the state in which everybody is at its start."""
    origin = _code(group.start, num_vertices)
    front.steps[origin] = 0
    push(front.heap, 0, 0, origin, 0)
    front.counts[0] = 1


@kernel
def _walk_back(state: int, size: int, num_vertices: int, front: Front) -> IntArray:
    """(n + 1, G) vertices on the way to a state."""
    count = front.steps[state]
    path = np.empty((count + 1, size), np.int64)
    for row in range(count, -1, -1):
        code = state
        for agent in range(size - 1, -1, -1):
            path[row, agent] = code % num_vertices
            code //= num_vertices
        state = front.parent[state]
    return path


@kernel
def _search(
    group: Group, graph: Graph, front: Front, most: int, most_tried: int
) -> tuple[int, IntArray]:
    """A* over joint states, fewest steps first: the final state, -1 if not found yet; and the queue.

    It goes on until `most` states have been expanded in all, or about `most_tried` moves tried in this call.
    """
    start, goal, hops, free, apart = group
    vertices, leaving = graph.vertices, graph.leaving
    parent, steps, heap, counts = front
    size = len(start)
    num_vertices = len(vertices)
    here = np.empty(size, np.int64)
    after = np.empty(size, np.int64)
    place = np.empty(size, np.int64)
    final = _code(goal, num_vertices)
    entries, expansions = counts[0], counts[1]
    tried = 0
    while entries > 0 and expansions < most and tried < most_tried:
        state = heap[0, 1]
        count = heap[0, 2]
        drop_root(heap, entries)
        entries -= 1
        if steps[state] != count:
            continue
        if state == final:
            return state, heap
        expansions += 1
        code = state
        for agent in range(size - 1, -1, -1):
            here[agent] = code % num_vertices
            code //= num_vertices
        # An odometer over the moves of all agents; place offsets - 1 stands for waiting.
        for agent in range(size):
            place[agent] = leaving.offsets[here[agent]] - 1
        agent = 0
        while agent >= 0:
            tried += 1
            if agent == size:
                code = 0
                to_go = 0
                total = 0
                for other in range(size):
                    code = code * num_vertices + after[other]
                    to_go = max(to_go, hops[other, after[other]])
                    total += hops[other, after[other]]
                if count + 1 < steps[code]:
                    steps[code] = count + 1
                    parent[code] = state
                    heap = with_room(heap, entries + 1)
                    push(heap, entries, ((count + 1 + to_go) << 24) + total, code, count + 1)
                    entries += 1
                agent -= 1
                continue
            if place[agent] >= leaving.offsets[here[agent] + 1]:
                place[agent] = leaving.offsets[here[agent]] - 1
                agent -= 1
                continue
            waits = place[agent] < leaving.offsets[here[agent]]
            move = here[agent] if waits else leaving.moves[place[agent]]
            place[agent] += 1
            if not free[agent, move]:
                continue
            after[agent] = leaving.ends[move]
            if hops[agent, after[agent]] >= UNREACHABLE:
                continue
            clear = True
            for other in range(agent):
                gap = _least_gap(
                    vertices[here[agent], 0] - vertices[here[other], 0],
                    vertices[here[agent], 1] - vertices[here[other], 1],
                    vertices[after[agent], 0] - vertices[after[other], 0],
                    vertices[after[agent], 1] - vertices[after[other], 1],
                )
                if gap <= apart[agent, other] * apart[agent, other]:
                    clear = False
                    break
            if clear:
                agent += 1
    counts[0], counts[1] = entries, expansions
    return -1, heap
