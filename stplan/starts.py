"""Several starts: seeds of different homotopy classes, of which the cheapest is optimised.

An optimisation keeps the homotopy class of its seed (who passes whom on which side), and classes differ in
cost by more than any option of the solver is worth. Among seeds that relaxation found, the cheapest seed
leads to the cheapest plan, so only one of them is optimised; docs/performance.md has the figures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from stplan.certify.metrics import kinetic_energy, turning
from stplan.errors import SeedingError
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Seed, find_seed
from stplan.world import FreeSpace
from stplan.world_lines import WorldLines

# `solver.starts: auto` spends about as many relaxed agents as this, and at most so many starts: the more
# agents there are, the less their classes differ in sum.
RELAXED_AGENTS = 256
MOST_STARTS = 8


def best_seed(
    scene: Scene, free_space: FreeSpace | None, *, progress: Callable[[str], None]
) -> Seed:
    """The cheapest of `solver.starts` seeds, found with `seeding.rng_seed` and the numbers after it.

    Raises:
        SeedingError: the first start found none.
    """
    best = find_seed(scene, free_space, progress=progress)
    starts = scene.solver.starts or _worthwhile_starts(best, len(scene.agents))
    least, chosen = own_cost(scene, best.world_lines), 0
    for start in range(1, starts):
        other = replace(
            scene, seeding=replace(scene.seeding, rng_seed=scene.seeding.rng_seed + start)
        )
        try:
            seed = find_seed(other, free_space, progress=lambda line: None)
        except SeedingError:
            continue
        cost = own_cost(scene, seed.world_lines)
        if cost < least:
            best, least, chosen = seed, cost, start
    if starts > 1:
        progress(f"start {chosen + 1} of {starts} is the cheapest")
    return replace(best, record=best.record | {"starts": starts, "start": chosen + 1})


def own_cost(scene: Scene, lines: WorldLines) -> float:
    """What single agents pay on `lines`: kinetic, acceleration and arrival cost."""
    total = 0.0
    for agent, curve in zip(scene.agents, lines.curves(), strict=True):
        weights = agent.weights
        total += weights.kinetic * kinetic_energy(agent, curve)
        if weights.acceleration:
            total += weights.acceleration * turning(curve, scene.time_scale)
        if agent.preferred_time is not None:
            total += weights.arrival * 0.5 * (float(curve[-1, 2]) - agent.preferred_time) ** 2
    return total


def _worthwhile_starts(first: Seed, num_agents: int) -> int:
    """How many starts `auto` makes: search finds much the same seed every time."""
    if first.found_by != "relaxation" or num_agents == 1:
        return 1
    return max(1, min(MOST_STARTS, RELAXED_AGENTS // num_agents))
