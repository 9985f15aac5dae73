"""Large-neighbourhood search: curves that still touch, replanned a few agents at a time.

All agents have a curve, some pairs touch. Again and again one touching agent, those it touches and
some that pass nearby are taken out and replanned in random order among all the others, some held
at their starts for a while. An agent without a free way keeps its old curve or takes the one
that touches fewest. The exchange is kept when no more pairs touch than before, now and then
also when a few more do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.callbacks import Stop, never
from stplan.deadline import heed
from stplan.seeding.search.conflicts import CurveSet
from stplan.seeding.search.layered_dijkstra import space_time_length
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.seeder import SeedAttempt

NAME = "repair"

LARGEST_NEIGHBOURHOOD = 8
# A neighbour passes within so many times the required distance.
NEARBY = 6.0
# Price of a blocked move, in mean costs of a move.
PENALTIES = (20.0, 50.0, 200.0)
# In crowds of more than so many a way through rods is sought by intervals, not layer by layer: the table is
# large, and touching few is all that matters. There a rod counts as so many layers.
CROWD = 60
LAYERS_A_ROD = 1000
# One more touching pair is accepted with this probability, two with its square.
ACCEPT_WORSE = 0.04
# What is worse by more pairs than this is not looked at further in a crowd.
MOST_WORSE = 1


def first_curves(
    planner: LayeredPlanner,
    rng: np.random.Generator,
    stopped: Stop = never,
) -> list[FloatArray] | None:
    """Curves planned in random order, each free if it can be, else touching as few as it can.

    None if someone has no way at all, or if `stopped`.
    """
    planner.reset()
    curves = [path if path is not None else np.empty((0, 3)) for path in planner.problem.paths]
    for agent in (int(agent) for agent in rng.permutation(np.array(planner.movers))):
        if stopped():
            return None
        path = _path(planner, agent)
        if path is None:
            path = _least_touching(planner, agent, PENALTIES[0], rng)
        if path is None:
            return None
        curves[agent] = planner.curve(agent, path)
        planner.add(planner.blocks(agent, curves[agent]))
    return curves


def _path(planner: LayeredPlanner, agent: int, hold: int = 0) -> IntArray | None:
    """The earliest way that touches nobody, None where there is none.

    In a crowd none is sought but by those who are held: the one that touches fewest comes out as early.
    """
    if hold == 0 and len(planner.movers) > CROWD:
        return None
    return planner.path(agent, hold)


def _least_touching(
    planner: LayeredPlanner, agent: int, penalty: float, rng: np.random.Generator
) -> IntArray | None:
    """A way through other rods at a `penalty`, in mean costs of a move; a little random.

    In a crowd it is the one through the fewest.
    """
    if len(planner.movers) > CROWD:
        return planner.soft_path(agent, LAYERS_A_ROD)
    cost = space_time_length(planner.graph, planner.grid.height)
    cost *= 1.0 + 0.1 * rng.random(len(cost))
    return planner.cheapest_path(agent, cost, penalty * float(cost.mean()))


def replan_neighbourhoods(
    planner: LayeredPlanner,
    curves: Sequence[FloatArray],
    rng: np.random.Generator,
    max_iterations: int,
    stopped: Stop,
) -> SeedAttempt:
    """Replan neighbourhoods of `curves` until no pair touches, or a limit is hit."""
    planner.reset()
    state = CurveSet(planner)
    for agent, curve in enumerate(curves):
        state.put(agent, curve)
    for agent in planner.movers:
        heed()
        planner.add(state.blocks(agent))
    movable = np.zeros(planner.problem.num_agents, dtype=bool)
    movable[planner.movers] = True
    best = state.copy()
    iterations = 0
    while state.num_conflicts > 0 and iterations < max_iterations and not stopped():
        chosen = _neighbourhood(state, movable, rng)
        if not chosen:
            break
        iterations += 1
        before = state.copy()
        whole = _replan(planner, state, chosen, rng, stopped, before.num_conflicts + MOST_WORSE)
        worse = state.num_conflicts - before.num_conflicts
        if not whole or (worse > 0 and rng.random() > ACCEPT_WORSE**worse):
            for agent in chosen:
                planner.remove(state.blocks(agent))
                planner.add(before.blocks(agent))
            state = before
        elif state.num_conflicts < best.num_conflicts:
            best = state.copy()
    pairs = tuple((int(a), int(b)) for a, b in np.argwhere(np.triu(best.conflicts)))
    found = SeedAttempt(NAME, best.all_curves(), clear=not pairs, touching=pairs)
    return found.counting(iterations)


def _neighbourhood(state: CurveSet, movable: BoolArray, rng: np.random.Generator) -> list[int]:
    """A touching agent, some that it touches, and some that pass nearby."""
    touching = np.flatnonzero(state.conflicts.any(axis=1) & movable)
    if len(touching) == 0:
        return []
    first = int(rng.choice(touching))
    size = int(rng.integers(2, LARGEST_NEIGHBOURHOOD + 1))
    others = rng.permutation(np.flatnonzero(state.conflicts[first] & movable))
    chosen = [first, *(int(other) for other in others[: size - 1])]
    if len(chosen) < size:
        near = state.nearest(first, 2 * LARGEST_NEIGHBOURHOOD, NEARBY)
        free = [agent for agent in near if movable[agent] and agent not in chosen]
        picked = rng.permutation(np.array(free, dtype=np.int64))[: size - len(chosen)]
        chosen += [int(agent) for agent in picked]
    return chosen


def _replan(
    planner: LayeredPlanner,
    state: CurveSet,
    chosen: list[int],
    rng: np.random.Generator,
    stopped: Stop,
    most: int,
) -> bool:
    """Give the `chosen` agents other curves, one after another in random order, unless `stopped`.

    In a crowd the rest is left out when more than `most` pairs touch: False then.
    """
    old = {agent: state.curves[agent] for agent in chosen}
    for agent in chosen:
        planner.remove(state.blocks(agent))
        state.put(agent, None)
    penalty = float(rng.choice(PENALTIES))
    crowd = len(planner.movers) > CROWD
    for agent in (int(agent) for agent in rng.permutation(np.array(chosen))):
        slack = max(int(planner.slack[agent]), 0)
        hold = int(rng.integers(0, slack // 2 + 2)) if rng.random() < 0.4 else 0
        path = None if stopped() else _path(planner, agent, hold)
        if path is None and hold > 0 and not stopped():
            path = _path(planner, agent)
        if path is None and not stopped() and (crowd or rng.random() < 0.8):
            path = _least_touching(planner, agent, penalty, rng)
        curve = old[agent] if path is None else planner.curve(agent, path)
        state.put(agent, curve)
        planner.add(state.blocks(agent))
        if crowd and state.num_conflicts > most:
            return False
    return True
