"""One step of many agents at once: where everybody goes, those asked first who matter most.

Agents are asked in turn; whoever stands in the way of a move is asked next, as in PIBT (Okumura et al.,
2022).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import inlined, inner
from stplan.geometry.segments import plane_point, squared_distance
from stplan.seeding.search.graph import MoveRows

IndexArray = NDArray[np.int32]

# Failures after which the agents of a step are no longer asked otherwise, an agent.
FAILURES = 12
# Vertices equally near the goal are tried in random order: nearer than this share of an edge is equal.
EQUAL = 0.05


class Company(NamedTuple):
    """A agents that move at once.

    Attributes:
        start, goal: (A,) vertices.
        to_go: (A, V) length of the shortest way to the goal (m), inf where there is none.
        free: (A, M) moves clear of the walls.
        apart: (A, A) distances kept at equal times, m.
        vertices: (V, 2) places, m.
        leaving: moves that leave every vertex.
        following: whether distances are kept at equal times only, so that one may follow another at once.
    """

    start: IntArray
    goal: IntArray
    to_go: FloatArray
    free: BoolArray
    apart: FloatArray
    vertices: FloatArray
    leaving: MoveRows
    following: bool


@inner
def random_number(counts: IntArray) -> int:
    """The next of the random numbers, 0 up to 2^31."""
    counts[4] = (counts[4] * 1103515245 + 12345) & 0x7FFFFFFF
    return counts[4] >> 8


class StepWork(NamedTuple):
    """Agents asked so far in one step, in the order in which they were.

    Attributes:
        frames: (A, 4) agent, number of its candidates, next one, frame to go back to (-1: the one before).
        choices: (A, K) candidates: vertices, best first.
        keys: (K,) how good they are.
        frame_of: (A,) of every agent.
    """

    frames: IntArray
    choices: IntArray
    keys: FloatArray
    frame_of: IntArray


@inner
def workplace(size: int, company: Company) -> StepWork:
    """Room for the agents of one step."""
    offsets = company.leaving.offsets
    most = 1
    for vertex in range(len(offsets) - 1):
        most = max(most, offsets[vertex + 1] - offsets[vertex] + 1)
    return StepWork(
        np.empty((size, 4), np.int64),
        np.empty((size, most), np.int64),
        np.empty(most),
        np.empty(size, np.int64),
    )


@inner
def successor(
    here: IndexArray, order: IntArray, forced: IntArray, company: Company,
    after: IndexArray, work: StepWork, counts: IntArray,
) -> bool:  # fmt: skip
    """Where everybody goes from `here` in `after`, by priority; False where that was not found."""
    size = len(here)
    after[:] = -1
    frames, frame, failures = work.frames, -1, 0
    while True:
        agent, back = _next_agent(here, after, order, forced, company, work)
        if agent < 0:
            return True
        frame += 1
        frames[frame, 0], frames[frame, 2], frames[frame, 3] = agent, 0, back
        frames[frame, 1] = _candidates(
            agent, here[agent], forced[agent], frame, company, work, counts
        )
        work.frame_of[agent] = frame
        while True:
            agent = frames[frame, 0]
            if frames[frame, 2] == frames[frame, 1]:
                failures += 1
                back = frames[frame, 3] if frames[frame, 3] >= 0 else frame - 1
                if back < 0 or failures > FAILURES * size:
                    return False
                while frame > back:
                    after[frames[frame, 0]] = -1
                    frame -= 1
                after[frames[frame, 0]] = -1
                continue
            vertex = work.choices[frame, frames[frame, 2]]
            frames[frame, 2] += 1
            if _fits(agent, here, vertex, after, company):
                after[agent] = vertex
                break


@inner
def _next_agent(
    here: IndexArray, after: IndexArray, order: IntArray, forced: IntArray, company: Company,
    work: StepWork,
) -> tuple[int, int]:  # fmt: skip
    """Who is asked next, and the frame to go back to if it has no answer; -1, -1 if all were asked."""
    first = -1
    for agent in order:
        if after[agent] >= 0:
            continue
        if forced[agent] >= 0:
            return agent, -1
        if first < 0:
            first = agent
    for agent in order:
        if after[agent] >= 0:
            continue
        for other in range(len(order)):
            if after[other] >= 0 and not _clear(
                agent, here[agent], here[agent], other, here[other], after[other], company
            ):
                return agent, work.frame_of[other]
    return first, -1


@inner
def _candidates(
    agent: int,
    here: int,
    forced: int,
    frame: int,
    company: Company,
    work: StepWork,
    counts: IntArray,
) -> int:
    """Where an agent may go, nearest to its goal first; how many places."""
    if forced >= 0:
        work.choices[frame, 0] = forced
        return 1
    leaving, choices, keys = company.leaving, work.choices[frame], work.keys
    count = 0
    for place in range(leaving.offsets[here] - 1, leaving.offsets[here + 1]):
        move = here if place < leaving.offsets[here] else leaving.moves[place]
        if not company.free[agent, move]:
            continue
        vertex = leaving.ends[move]
        key = company.to_go[agent, vertex]
        key += EQUAL * company.apart[agent, agent] * (random_number(counts) % 1024) / 1024.0
        slot = count
        while slot > 0 and keys[slot - 1] > key:
            keys[slot], choices[slot] = keys[slot - 1], choices[slot - 1]
            slot -= 1
        keys[slot], choices[slot] = key, vertex
        count += 1
    return count


@inner
def _fits(agent: int, here: IndexArray, vertex: int, after: IndexArray, company: Company) -> bool:
    """Whether a move keeps clear of all moves chosen so far."""
    for other in range(len(here)):
        if (
            after[other] >= 0
            and other != agent
            and not _clear(agent, here[agent], vertex, other, here[other], after[other], company)
        ):
            return False
    return True


@inlined
def _clear(
    a: int, a_from: int, a_to: int, b: int, b_from: int, b_to: int, company: Company
) -> bool:
    """Whether two agents that move straight at once keep their distance."""
    apart = company.apart[a, b]
    if apart <= 0.0:
        return True
    places = company.vertices
    if not company.following:
        gap = squared_distance(
            plane_point(places, a_from), plane_point(places, a_to),
            plane_point(places, b_from), plane_point(places, b_to),
        )  # fmt: skip
        return gap > apart * apart
    x = places[a_from, 0] - places[b_from, 0]
    y = places[a_from, 1] - places[b_from, 1]
    dx = places[a_to, 0] - places[b_to, 0] - x
    dy = places[a_to, 1] - places[b_to, 1] - y
    square = dx * dx + dy * dy
    share = 0.0
    if square > 0.0:
        share = min(max(-(x * dx + y * dy) / square, 0.0), 1.0)
    x += share * dx
    y += share * dy
    return x * x + y * y > apart * apart
