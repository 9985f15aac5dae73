"""From steps that all agents take together to curves: needless moves left out, each move as early as can be.

A joint search counts steps, in which everybody moves or waits. What matters of them is in which order agents
pass where they would touch. Moves that lead back to where they began, while nobody needed the place, are left
out; then every move begins as soon as all earlier ones that come too near it have ended, and the whole is
stretched over the time there is. Followers move one after another that way: in space-time they need less
time than side by side at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from stplan.arrays import FloatArray, IntArray
from stplan.seeding.search.graph import Graph


class Moves(NamedTuple):
    """Moves of all agents, in the order of their steps.

    Attributes:
        agent: (M,) column in the steps.
        tail, head: (M,) vertices from and to.
        step: (M,) in which it was made.
    """

    agent: IntArray
    tail: IntArray
    head: IntArray
    step: IntArray


def without_loops(graph: Graph, steps: IntArray, apart: FloatArray) -> IntArray:
    """`steps` (n + 1, A) with loops waited out where nobody comes within `apart` (A, A) m; fewer rows."""
    steps = steps.copy()
    changed = True
    while changed:
        changed = False
        for agent in range(steps.shape[1]):
            for first, last in _loops(steps[:, agent]):
                waiting = steps.copy()
                waiting[first:last, agent] = steps[first, agent]
                if _clear_of(graph, waiting[first : last + 1], agent, apart[agent]):
                    steps, changed = waiting, True
                    break
    moving = np.concatenate([[True], (np.diff(steps, axis=0) != 0).any(axis=1)])
    return steps[moving]


def _loops(path: IntArray) -> list[tuple[int, int]]:
    """First and last steps between which an agent leaves a vertex and comes back, the longest first."""
    found = []
    for vertex in np.unique(path):
        at = np.flatnonzero(path == vertex)
        found += [
            (int(a), int(b))
            for k, a in enumerate(at)
            for b in at[k + 1 :]
            if (path[a:b] != vertex).any()
        ]
    return sorted(found, key=lambda loop: loop[0] - loop[1])


def _clear_of(graph: Graph, steps: IntArray, agent: int, apart: FloatArray) -> bool:
    """Whether one that waits keeps `apart` (A,) from all others during `steps`."""
    place = graph.vertices[steps[0, agent]]
    head = graph.vertices[steps[:-1]] - place
    step = graph.vertices[steps[1:]] - place - head
    square = (step**2).sum(axis=2)
    share = np.clip(-(head * step).sum(axis=2) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    gap = np.hypot(*np.moveaxis(head + share[..., None] * step, 2, 0)).min(axis=0)
    gap[agent] = np.inf
    return bool((gap > apart).all())


def moves_of(steps: IntArray) -> Moves:
    """All that is moved in `steps` (n + 1, A)."""
    step, agent = np.nonzero(np.diff(steps, axis=0))
    return Moves(agent, steps[step, agent], steps[step + 1, agent], step)


def begins(graph: Graph, moves: Moves, apart: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """(M,) when moves begin and end, in lengths; None where some of a step wait for each other in turn."""
    count = len(moves.agent)
    tails, heads = graph.vertices[moves.tail], graph.vertices[moves.head]
    lines = shapely.linestrings(np.stack([tails, heads], axis=1))
    near = shapely.distance(lines[:, None], lines[None]) <= apart[moves.agent][:, moves.agent]
    # Of two in one step the one goes first whose place the other one needs.
    entered = heads[:, None] - tails[None]
    needs = np.hypot(entered[..., 0], entered[..., 1]) <= apart[moves.agent][:, moves.agent]
    same = (moves.step[:, None] == moves.step) & (moves.agent[:, None] != moves.agent)
    later = (moves.step[:, None] > moves.step) | (same & needs)
    before = near & later | (moves.agent[:, None] == moves.agent) & (
        moves.step[:, None] > moves.step
    )
    if (before & before.T).any() or (same & near & ~(before | before.T)).any():
        return None
    lengths = np.hypot(*(heads - tails).T)
    begin = np.full(count, -1.0)
    todo = np.ones(count, dtype=bool)
    for step in np.unique(moves.step):
        own = np.flatnonzero(moves.step == step)
        while len(own):
            ready = [k for k in own.tolist() if not (before[k] & todo).any()]
            if not ready:
                return None
            for k in ready:
                begin[k] = np.max((begin + lengths)[before[k]], initial=0.0)
                todo[k] = False
            own = own[todo[own]]
    return begin, begin + lengths


def scheduled_curves(
    graph: Graph, steps: IntArray, apart: FloatArray, begin: float, end: float
) -> list[FloatArray] | None:
    """One (n, 3) curve a column of `steps` from `begin` to at most `end` (s), None where `begins` is."""
    moves = moves_of(steps)
    times = begins(graph, moves, apart)
    if times is None:
        return None
    unit = (end - begin) / max(float(times[1].max(initial=0.0)), 1e-300)
    curves = []
    for column in range(steps.shape[1]):
        own = np.flatnonzero(moves.agent == column)
        place = graph.vertices[steps[0, column]]
        knots = [np.array([*place, begin])]
        for k in own:
            head = begin + unit * times[0][k]
            if head > knots[-1][2] + 1e-9 * (end - begin):
                knots.append(np.array([*graph.vertices[moves.tail[k]], head]))
            knots.append(np.array([*graph.vertices[moves.head[k]], begin + unit * times[1][k]]))
        if len(knots) == 1:
            knots.append(np.array([*place, end]))
        curve = np.vstack(knots)
        curve[-1, 2] = min(curve[-1, 2], end)
        curves.append(curve)
    return curves
