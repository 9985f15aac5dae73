"""Complete search of the joint positions of many agents on one roadmap, in the manner of LaCAM.

A configuration is the vertices of all agents at once. Configurations are searched depth first (Okumura,
2023); successors of each are generated lazily: agents are asked in turn, those furthest from their goals
first, and whoever stands in the way of a move is asked next, as in PIBT (Okumura et al., 2022). Constraints,
"this agent goes there", are tried in ever larger sets, so that in the end every successor has been generated:
what is not found when all is searched is not on the roadmap.

Steps have no time of their own. In a step everybody moves along one edge at constant speed or waits, and
keeps a distance from everybody else at equal times; or, where nobody may follow closely, from all that others
pass in the step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import inner, kernel
from stplan.seeding.search.joint_step import (
    Company,
    IndexArray,
    random_number,
    successor,
    workplace,
)

# Configurations, and iterations, at most.
MOST_NODES = 400_000
MOST_ITERATIONS = 2_000_000
# Every so many times that a known configuration comes up again the search goes on from the first one.
RESTART = 1000

FOUND, EXHAUSTED, UNFINISHED, FULL = 0, 1, 2, 3


class Memory(NamedTuple):
    """What a search knows so far; none of it is looked at but by the search.

    Attributes:
        places: (N, A) vertices of all configurations.
        waited: (N, A) priorities: steps since an agent was at its goal, and a bit of its distance.
        before: (N, 3) the configuration before, first and last constraint not tried yet (-1: none).
        constraints: (C, 5) set it belongs to, agent, vertex, how many there are, the next one to try.
        stack: configurations to go on with.
        table: hash table of configurations.
        counts: configurations, constraints, stack, iterations, state of the random numbers.
    """

    places: IndexArray
    waited: FloatArray
    before: IndexArray
    constraints: IndexArray
    stack: IndexArray
    table: IndexArray
    counts: IntArray


def new_memory(company: Company, rng_seed: int) -> Memory:
    """Memory of a search that knows the first configuration only. What is not touched takes no room."""
    size = len(company.start)
    degree = int(np.diff(company.leaving.offsets).max(initial=0)) + 1
    memory = Memory(
        np.empty((MOST_NODES, size), np.int32),
        np.empty((MOST_NODES, size)),
        np.empty((MOST_NODES, 3), np.int32),
        np.empty((2 * MOST_NODES + MOST_ITERATIONS * degree, 5), np.int32),
        np.empty(MOST_ITERATIONS + 2, np.int32),
        np.full(1 << (2 * MOST_NODES - 1).bit_length(), -1, np.int32),
        np.array([0, 0, 0, 0, 2 * rng_seed + 1], dtype=np.int64),
    )
    _begin(company, memory)
    return memory


@kernel
def _begin(company: Company, memory: Memory) -> None:
    """Enter the first configuration."""
    size = len(company.start)
    farthest = 1.0
    for agent in range(size):
        farthest = max(farthest, company.to_go[agent, company.start[agent]])
    places = company.start.astype(np.int32)
    _add(places, -1, memory)
    for agent in range(size):
        memory.waited[0, agent] = company.to_go[agent, company.start[agent]] / (2.0 * farthest)
    memory.stack[0] = 0
    memory.counts[2] = 1


@kernel
def explore(company: Company, memory: Memory, iterations: int) -> int:
    """Search on for so many `iterations`: FOUND, EXHAUSTED, UNFINISHED or FULL."""
    size = len(company.start)
    counts = memory.counts
    forced = np.empty(size, np.int64)
    after = np.empty(size, np.int32)
    order = np.empty(size, np.int64)
    work = workplace(size, company)
    for _ in range(iterations):
        if counts[2] == 0:
            return EXHAUSTED
        if counts[3] >= MOST_ITERATIONS or counts[0] >= MOST_NODES - 1:
            return FULL
        node = memory.stack[counts[2] - 1]
        if _is_goal(memory.places[node], company.goal):
            return FOUND
        constraint = memory.before[node, 1]
        if constraint < 0:
            counts[2] -= 1
            continue
        counts[3] += 1
        memory.before[node, 1] = memory.constraints[constraint, 4]
        _sort(memory.waited[node], order)
        _refine(node, constraint, order, company, memory)
        forced[:] = -1
        while memory.constraints[constraint, 0] >= 0:
            forced[memory.constraints[constraint, 1]] = memory.constraints[constraint, 2]
            constraint = memory.constraints[constraint, 0]
        if not successor(memory.places[node], order, forced, company, after, work, counts):
            continue
        known = _find(after, memory)
        if known >= 0:
            if random_number(counts) % RESTART == 0:
                known = 0
            memory.stack[counts[2]] = known
            counts[2] += 1
            continue
        new = counts[0]
        _add(after, node, memory)
        for agent in range(size):
            at_goal = after[agent] == company.goal[agent]
            waited = memory.waited[node, agent]
            memory.waited[new, agent] = waited - np.floor(waited) if at_goal else waited + 1.0
        memory.stack[counts[2]] = new
        counts[2] += 1
    return UNFINISHED


@kernel
def steps_found(memory: Memory) -> IntArray:
    """(n + 1, A) vertices of all agents after every step to the configuration found last."""
    node = memory.stack[memory.counts[2] - 1]
    count, own = 0, node
    while own >= 0:
        count, own = count + 1, memory.before[own, 0]
    steps = np.empty((count, memory.places.shape[1]), np.int64)
    for row in range(count - 1, -1, -1):
        steps[row] = memory.places[node]
        node = memory.before[node, 0]
    return steps


@inner
def _is_goal(places: IndexArray, goal: IntArray) -> bool:
    """Whether everybody is at its goal."""
    apart = 0
    for agent in range(len(goal)):
        apart += places[agent] != goal[agent]
    return apart == 0


@inner
def _sort(waited: FloatArray, order: IntArray) -> None:
    """(A,) agents into `order`, those that have waited longest first."""
    for agent in range(len(order)):
        place = agent
        while place > 0 and waited[order[place - 1]] < waited[agent]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = agent


@inner
def _slot(places: IndexArray, memory: Memory) -> np.int64:
    """Where a configuration is in the hash table, or would be."""
    mask = len(memory.table) - 1
    code = np.uint64(14695981039346656037)
    for agent in range(len(places)):
        code = (code ^ np.uint64(places[agent])) * np.uint64(1099511628211)
    slot = np.int64((code ^ (code >> np.uint64(29))) & np.uint64(mask))
    while memory.table[slot] >= 0:
        other = memory.places[memory.table[slot]]
        same = True
        for agent in range(len(places)):
            if other[agent] != places[agent]:
                same = False
                break
        if same:
            break
        slot = (slot + 1) & mask
    return slot


@inner
def _find(places: IndexArray, memory: Memory) -> int:
    """The number of a configuration, -1 if it is new."""
    return int(memory.table[_slot(places, memory)])


@inner
def _add(places: IndexArray, before: int, memory: Memory) -> None:
    """Enter a new configuration with the empty set of constraints."""
    counts = memory.counts
    node, constraint = counts[0], counts[1]
    memory.places[node] = places
    memory.table[_slot(places, memory)] = node
    row = memory.before[node]
    row[0], row[1], row[2] = before, constraint, constraint
    memory.constraints[constraint, 0] = -1
    memory.constraints[constraint, 3] = 0
    memory.constraints[constraint, 4] = -1
    counts[0] += 1
    counts[1] += 1


@inner
def _refine(node: int, constraint: int, order: IntArray, company: Company, memory: Memory) -> None:
    """Queue the sets of constraints with one more: every move of the next agent."""
    counts, leaving = memory.counts, company.leaving
    depth = memory.constraints[constraint, 3]
    if depth == len(order):
        return
    agent = order[depth]
    here = memory.places[node, agent]
    for place in range(leaving.offsets[here] - 1, leaving.offsets[here + 1]):
        move = here if place < leaving.offsets[here] else leaving.moves[place]
        if not company.free[agent, move]:
            continue
        new = counts[1]
        entry = memory.constraints[new]
        entry[0], entry[1], entry[2], entry[3], entry[4] = (
            constraint, agent, leaving.ends[move], depth + 1, -1,
        )  # fmt: skip
        if memory.before[node, 1] < 0:
            memory.before[node, 1] = new
        else:
            memory.constraints[memory.before[node, 2], 4] = new
        memory.before[node, 2] = new
        counts[1] += 1
