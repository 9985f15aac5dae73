"""Many agents a block at a time.

The time of a direct solver grows faster than the number of agents. So agents are split into blocks by
recursive bisection, every block is optimised on its own against the rods of those who come near it, as they
are by then, and that is done again with other splits (of middles, starts and goals of the ways), so that
who was on the edge of a block is in the middle of another one, until the cost has all but stopped falling.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.optimize.components import connected
from stplan.optimize.continuation import LiveLine, Optimisation, OuterIteration
from stplan.optimize.parts import DividedProblem
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.status import Status

# More agents than this are optimised in blocks of so many.
FEW, BLOCK = 400, 64
# Sweeps at most, each as long as the last one lowered the cost by this part.
MOST_SWEEPS, WORTHWHILE = 4, 1e-3
# Values of mu that a block may leave out, of the first ones: there are more sweeps to come.
FIRST_BEGIN, LATER_BEGIN = 2, 3
# Blocks are judged by so many times the tolerance: others move afterwards.
ROUGHLY = 10.0


def block_size(problem: PlanningProblem) -> int | None:
    """How many agents a block has, None where all are optimised together."""
    asked = problem.scene.solver.blocks
    planning = int((~problem.prescribed).sum())
    if asked is None:
        return BLOCK if planning > FEW else None
    return None if asked == "all" or planning <= asked else asked


def optimise_blocks(
    problem: PlanningProblem,
    seed: WorldLines,
    size: int,
    *,
    progress: Callable[[str], None],
    stop: Callable[[], bool],
    live: LiveLine | None = None,
) -> Optimisation:
    """Sweeps over blocks of at most `size` agents until the cost has all but stopped falling."""
    parts = DividedProblem(problem, seed, stop)
    seed_costs = parts.costs(parts.formulation.scales.mu)
    price, status = parts.price(), Status.LIMIT
    done: list[OuterIteration] = []
    last = problem.scene.solver.outer_iterations - 1
    for sweep in range(MOST_SWEEPS):
        used, status = 0, Status.LIMIT
        blocks = split(problem, sweep, size)
        for number, block in enumerate(blocks, start=1):
            if stop():
                status = Status.INTERRUPTED
                break
            if live is not None:
                live(partial("sweep {}: block {} of {}".format, sweep + 1, number, len(blocks)))
            begin = min(FIRST_BEGIN if sweep == 0 else LATER_BEGIN, last)
            found = parts.optimise(block, begin=begin, tolerance=ROUGHLY)
            used += 0 if found is None else found.iterations
        before, price = price, parts.price()
        if status is not Status.INTERRUPTED and before - price <= WORTHWHILE * before:
            status = Status.CONVERGED
        least = parts.least_clearance()
        mu = problem.frame.cost * parts.last_mu
        done.append(OuterIteration(sweep + 1, mu, used, 0, price, least, status))
        progress(f"sweep {sweep + 1}  cost {price:.6g}  {used} iterations  {status}")
        if status is not Status.LIMIT:
            break
    return parts.optimisation(status, done, seed_costs)


def split(problem: PlanningProblem, sweep: int, size: int) -> list[IntArray]:
    """Blocks of at most `size` of the agents that plan, by recursive bisection of their places.

    Of the middles of their ways in the first sweep, of their starts in the second, of their goals in the
    third. Who has to meet or is drawn together stays together.
    """
    places = (0.5 * (problem.starts + problem.goals), problem.starts, problem.goals)[sweep % 3]
    clusters = connected(problem, np.zeros_like(problem.collides))
    middles = np.array([places[cluster].mean(axis=0) for cluster in clusters])
    return _bisected(clusters, middles, np.arange(len(clusters)), size)


def _bisected(
    clusters: Sequence[IntArray], middles: FloatArray, chosen: IntArray, size: int
) -> list[IntArray]:
    total = sum(len(clusters[one]) for one in chosen)
    if total <= size or len(chosen) == 1:
        return [np.sort(np.concatenate([clusters[one] for one in chosen]))]
    axis = int(np.ptp(middles[chosen], axis=0).argmax())
    order = chosen[np.argsort(middles[chosen, axis], kind="stable")]
    counts = np.cumsum([len(clusters[one]) for one in order])
    half = min(max(int(np.searchsorted(counts, total / 2)), 1), len(order) - 1)
    return [
        block
        for part in (order[:half], order[half:])
        for block in _bisected(clusters, middles, part, size)
    ]
