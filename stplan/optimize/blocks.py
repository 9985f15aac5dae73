"""Many agents a block at a time.

The time of a direct solver grows faster than the number of agents. So agents are split into blocks by
recursive bisection, every block is optimised on its own against the rods of those who come near it, as they
are by then, and that is done again with other splits (of middles, starts and goals of the ways), so that
who was on the edge of a block is in the middle of another one, until the cost has all but stopped falling.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.callbacks import Progress, Stop
from stplan.optimize.components import connected
from stplan.optimize.continuation import LiveLine, Optimisation, OuterIteration
from stplan.optimize.parts import DividedProblem, Part
from stplan.optimize.workers import THIS_PROCESS, Workers, WorkersFor
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.status import Status

# More agents than this are optimised in blocks of so many. In the open, where blocks have little to do with
# each other, they pay sooner: fields of 250 take three quarters of the time and cost 0.1 % more.
FEW, FEW_IN_THE_OPEN, BLOCK = 400, 200, 64
# Sweeps at most, each as long as the last one lowered the cost by this part.
MOST_SWEEPS, WORTHWHILE = 4, 1e-3
# Values of mu that a block may leave out, of the first ones: there are more sweeps to come.
FIRST_BEGIN, LATER_BEGIN = 2, 3
# Blocks are optimised at the same time as far as no more than this part of who is close to their agents,
# within so many ranges of the barriers, is moved meanwhile.
COUPLED, CLOSE = 0.15, 1.0
# Barriers around agents of other blocks, who have yet to move, are so many times as strong.
TOWARDS_OTHERS = 2.0
# No pair of agents.
ALONE = np.empty((0, 2), dtype=np.int64)
# Blocks are judged by so many times the tolerance: others move afterwards.
ROUGHLY = 10.0


def block_size(problem: PlanningProblem) -> int | None:
    """How many agents a block has, None where all are optimised together."""
    asked = problem.scene.solver.blocks
    planning = int((~problem.prescribed).sum())
    if asked is None:
        return BLOCK if planning > (FEW_IN_THE_OPEN if problem.boundary is None else FEW) else None
    return None if asked == "all" or planning <= asked else asked


def optimise_blocks(
    problem: PlanningProblem,
    seed: WorldLines,
    size: int,
    *,
    progress: Progress,
    stop: Stop,
    live: LiveLine | None = None,
    workers: WorkersFor = THIS_PROCESS,
) -> Optimisation:
    """Sweeps over blocks of at most `size` agents until the cost has all but stopped falling."""
    parts = DividedProblem(problem, seed, stop)
    seed_costs = parts.costs(parts.formulation.scales.mu)
    price, status = parts.price(), Status.LIMIT
    done: list[OuterIteration] = []
    with workers(parts) as crew:
        for sweep in range(MOST_SWEEPS):
            used = _sweep(parts, crew, sweep, size, live)
            before, price = price, parts.price()
            status = Status.LIMIT
            if stop():
                status = Status.INTERRUPTED
            elif before - price <= WORTHWHILE * before:
                status = Status.CONVERGED
            least = parts.least_clearance()
            mu = problem.frame.cost * parts.last_mu
            done.append(OuterIteration(sweep + 1, mu, used, 0, price, least, status))
            progress(f"sweep {sweep + 1}  cost {price:.6g}  {used} iterations  {status}")
            if status is not Status.LIMIT:
                break
    return parts.optimisation(status, done, seed_costs)


def _sweep(
    parts: DividedProblem, crew: Workers, sweep: int, size: int, live: LiveLine | None
) -> int:
    """Every block once, and who could not be moved with its own once more; the iterations it took."""
    problem, used = parts.problem, 0
    begin = min(
        FIRST_BEGIN if sweep == 0 else LATER_BEGIN, problem.scene.solver.outer_iterations - 1
    )
    clusters = connected(problem, ALONE)
    groups = np.zeros(problem.num_agents, dtype=np.int64)
    for number, cluster in enumerate(clusters, start=1):
        groups[cluster] = number
    blocks, left = split(problem, sweep, size), np.empty(0, dtype=np.int64)
    for _ in range(2):
        near = parts.surveyor.pairs_in_view(parts.knots, CLOSE)
        gone = 0
        for together in at_once(blocks, near, problem.num_agents):
            everyone = np.concatenate(together)
            asked = [
                Part(block, begin, ROUGHLY, np.setdiff1d(everyone, block), TOWARDS_OTHERS)
                for block in together
            ]
            told = _told(live, sweep, gone, len(blocks))
            for result in crew.optimise(asked, told):
                if result is not None:
                    used += result.iterations
                    left = np.append(left, parts.take_clear(result, groups))
            gone += len(together)
            if parts.stop():
                return used
        if not len(left):
            break
        blocks, left = split(problem, sweep, size, left), np.empty(0, dtype=np.int64)
    return used


def _told(live: LiveLine | None, sweep: int, gone: int, total: int) -> Callable[[int], None]:
    def told(done: int) -> None:
        if live is not None:
            live(lambda: f"sweep {sweep + 1}: {gone + done} of {total} blocks")

    return told


def at_once(blocks: Sequence[IntArray], near: IntArray, num_agents: int) -> list[list[IntArray]]:
    """`blocks` in groups that may be optimised at the same time, one group after another.

    Args:
        near: (N, 2) pairs of agents that are close to each other. No block has more than a part
            `COUPLED` of its own with others of its group.
    """
    own = np.full(num_agents, len(blocks))
    for number, block in enumerate(blocks):
        own[block] = number
    coupling = np.zeros((len(blocks) + 1, len(blocks) + 1))
    np.add.at(coupling, (own[near[:, 0]], own[near[:, 1]]), 1.0)
    coupling = coupling + coupling.T
    most = COUPLED * coupling.sum(axis=1)
    np.fill_diagonal(coupling, 0.0)
    groups, left = [], list(range(len(blocks)))
    while left:
        group = [left.pop(0)]
        loose = True
        while left and loose:
            with_group = coupling[:, group].sum(axis=1)
            best = min(left, key=lambda block: (with_group[block], block))
            tight = coupling[np.ix_([*group, best], [*group, best])].sum(axis=1)
            loose = bool((tight <= most[[*group, best]]).all())
            if loose:
                left.remove(best)
                group.append(best)
        groups.append([blocks[block] for block in sorted(group)])
    return groups


def split(
    problem: PlanningProblem, sweep: int, size: int, among: IntArray | None = None
) -> list[IntArray]:
    """Blocks of at most `size` of the agents that plan, of those `among` them, by recursive bisection.

    It is one of places: of the middles of their ways in the first sweep, of their starts in the second, of
    their goals in the third. Who has to meet or is drawn together stays together.
    """
    places = (0.5 * (problem.starts + problem.goals), problem.starts, problem.goals)[sweep % 3]
    clusters = connected(problem, ALONE)
    if among is not None:
        chosen = np.zeros(problem.num_agents, dtype=bool)
        chosen[among] = True
        clusters = [cluster for cluster in clusters if chosen[cluster].all()]
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
