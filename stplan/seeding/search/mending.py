"""Large-neighbourhood search from curves of any origin, say a relaxation that left a few pairs touching."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.requirement import Requirement, held_requirement
from stplan.problem.verification import verify
from stplan.reasons import Reason
from stplan.seeding.infeasibility import touching
from stplan.seeding.margins import SMALLER_MARGINS
from stplan.seeding.search.large_neighbourhood import replan_neighbourhoods
from stplan.seeding.search.levels import Level, Levels, off_roadmap, out_of_layers
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord

# Margins and multiples of the layers with which curves are mended.
_WIDEST, _NARROWEST = SMALLER_MARGINS[0], SMALLER_MARGINS[-1]
STAGES = ((_WIDEST, 1), (_WIDEST, 2), (_NARROWEST, 2), (_NARROWEST, 4))
ITERATIONS = 60
# Pairs that hold less than so many times R count as touching.
LEAST_HELD = 1.0005


@dataclass(frozen=True)
class Mending:
    """Replans the neighbourhoods of curves in which pairs still touch, the others reserved."""

    name: ClassVar = "repair"
    levels: Levels

    def attempt_from(self, curves: Sequence[FloatArray], budget: Budget) -> SeedAttempt:
        """`curves` (n, 3), one an agent, with other curves where pairs touch.

        Each must be clear of the walls and meet its ends. Agents that are not replanned keep their
        curves. Pairs that hold less than the margin need not hold more than they do.
        """
        problem = self.levels.problem
        reasons: tuple[Reason, ...] = ()
        tries = 0
        for number, (margin, layers) in enumerate(STAGES):
            level = self.levels.at(min(margin, problem.scene.seeding.margin))
            if level.journeys.stranded():
                reasons = reasons or off_roadmap(level)
                continue
            planner = level.planner(layers, _required(level, curves))
            if planner.too_late():
                reasons = reasons or out_of_layers(planner)
                continue
            budget.progress(
                f"large-neighbourhood search: {planner.graph.num_vertices} vertices, "
                f"{planner.grid.count} layers"
            )
            rng = np.random.default_rng([budget.rng_seed, number])
            mended = replan_neighbourhoods(planner, curves, rng, ITERATIONS, budget.spent)
            tries += mended.tries
            if mended.clear and not verify(problem, mended.curves):
                return replace(mended, record=SeedRecord(margin=level.margin, tries=tries))
            reasons = touching(problem, mended.curves, mended.touching)
            if budget.spent():
                break
        return SeedAttempt(self.name, record=SeedRecord(tries=tries), reasons=reasons)


def _required(level: Level, curves: Sequence[FloatArray]) -> Requirement:
    """What the curves hold of the level's margin, but no less than what counts as touching."""
    held = held_requirement(level.problem, curves, level.required)
    floor = np.minimum(level.required.rods, LEAST_HELD * level.problem.distance)
    return Requirement(np.maximum(held.rods, floor), level.required.walls)
