"""Priority-based search: a tree of partial orders, branched only where two rods touch.

Everybody starts on their own shortest way. A node with a touching pair has two children: in one the
first agent yields to the second, in the other the reverse; whoever yields is replanned around all
agents above it, and so are those below it that now touch. The tree is searched depth first, the
cheaper child first. Restarts hold random agents at their starts, which solves swaps that no
order solves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.callbacks import Stop
from stplan.seeding.search.conflicts import CurveSet
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.search.prioritized import random_holds
from stplan.seeding.seeder import SeedAttempt

NAME = "priority-based"


@dataclass(frozen=True)
class _PartialOrder:
    """Curves under a partial order: ``above[a, b]`` says that b yields to a, transitively."""

    curves: CurveSet
    above: BoolArray


def plan_priority_based(
    planner: LayeredPlanner,
    rng: np.random.Generator,
    max_restarts: int,
    max_nodes: int,
    stopped: Stop,
) -> SeedAttempt:
    """Search up to `max_restarts` trees of up to `max_nodes` nodes each."""
    nodes = 0
    holds = np.zeros(planner.problem.num_agents, dtype=np.int64)
    for restart in range(max_restarts):
        if restart > 0:
            holds = random_holds(planner, rng, max(1, len(planner.movers) // 2))
        curves, expanded = _search_tree(planner, holds, max_nodes, stopped)
        nodes += expanded
        if curves is not None:
            return SeedAttempt(NAME, curves, clear=True).counting(nodes)
        if stopped():
            break
    return SeedAttempt(NAME).counting(nodes)


def _search_tree(
    planner: LayeredPlanner, holds: IntArray, max_nodes: int, stopped: Stop
) -> tuple[list[FloatArray] | None, int]:
    """Curves or None, and the nodes expanded."""
    root = _root(planner, holds)
    if root is None:
        return None, 0
    stack = [root]
    nodes = 0
    while stack and nodes < max_nodes and not stopped():
        node = stack.pop()
        nodes += 1
        pair = _open_conflict(node)
        if pair is None:
            return node.curves.all_curves(), nodes
        children = []
        for upper, lower in (pair, pair[::-1]):
            child = _child(planner, node, upper, lower, holds)
            if child is not None:
                arrivals = sum(curve[-1, 2] for curve in child.curves.all_curves())
                children.append((arrivals, child))
        # The cheaper child is popped first.
        children.sort(key=lambda pair: -pair[0])
        stack += [child for _, child in children]
    return None, nodes


def _root(planner: LayeredPlanner, holds: IntArray) -> _PartialOrder | None:
    """Everybody alone; agents whose motion is prescribed are above all others."""
    planner.reset()
    curves = CurveSet(planner)
    for agent, path in enumerate(planner.problem.paths):
        if path is not None:
            curves.put(agent, path)
    for agent in planner.movers:
        way = planner.path(agent, int(holds[agent]))
        if way is None:
            return None
        curves.put(agent, planner.curve(agent, way))
    count = planner.problem.num_agents
    return _PartialOrder(curves, np.zeros((count, count), dtype=bool))


def _open_conflict(node: _PartialOrder) -> tuple[int, int] | None:
    """The first touching pair."""
    touching = np.argwhere(node.curves.conflicts)
    return (int(touching[0, 0]), int(touching[0, 1])) if len(touching) else None


def _child(
    planner: LayeredPlanner, node: _PartialOrder, upper: int, lower: int, holds: IntArray
) -> _PartialOrder | None:
    """`node` with `lower` below `upper`, replanned as that demands; None if that fails."""
    if node.above[lower, upper]:
        return None
    above = node.above.copy()
    uppers = np.append(np.flatnonzero(above[:, upper]), upper)
    lowers = np.append(np.flatnonzero(above[lower]), lower)
    above[np.ix_(uppers, lowers)] = True
    curves = node.curves.copy()
    below = sorted(np.flatnonzero(above[lower]), key=lambda agent: (above[:, agent].sum(), agent))
    for agent in [lower, *(int(other) for other in below)]:
        over = np.flatnonzero(above[:, agent])
        if agent != lower and not curves.conflicts[agent, over].any():
            continue
        for other in over:
            planner.add(curves.blocks(int(other)))
        path = planner.path(agent, int(holds[agent]))
        for other in over:
            planner.remove(curves.blocks(int(other)))
        if path is None:
            return None
        curves.put(agent, planner.curve(agent, path))
    return _PartialOrder(curves, above)
