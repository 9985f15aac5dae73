"""Seeding by search: levels, reservations and a schedule of planners, cheap ones first.

A stage is a margin and a number of layers; on each, prioritised planning, large-neighbourhood search and
priority-based search get counted efforts. Stages run from the margin asked for to ever smaller ones, from
few layers to many (a queue at a door needs more of them than the way is long), and again with more effort
until one succeeds or the time limit is hit. Nothing but that limit depends on the clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from stplan.problem.verification import verify
from stplan.reasons import Reason
from stplan.seeding.infeasibility import no_way_past, touching
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.joint import MOST_AGENTS, plan_jointly
from stplan.seeding.search.large_neighbourhood import (
    CROWD,
    first_curves,
    replan_neighbourhoods,
)
from stplan.seeding.search.levels import Levels, off_roadmap, out_of_layers
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.search.prioritized import plan_prioritized
from stplan.seeding.search.priority_based import plan_priority_based
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord

# Priority-based search grows slow with the number of agents; beyond a few it comes late.
FEW_PRIORITY_BASED = 12
MOST_PRIORITY_BASED = 40
# Stages of the first effort are soon gone through; then other seeders may have their turn.
SOON_EFFORT, MOST_EFFORT = 1, 128


@dataclass(frozen=True)
class Stage:
    """One step of the schedule: index of the margin, multiple of the layers, effort of planners."""

    level: int
    layers: int
    effort: int


def schedule(num_margins: int) -> list[Stage]:
    """Stages in order; the last ones have most effort and repeat what failed on more layers."""
    stages = [Stage(0, 1, 1), Stage(0, 2, 1)]
    stages += [Stage(level, 1, 1) for level in range(1, num_margins)]
    stages += [
        Stage(level, layers, effort)
        for layers, effort in ((2, 2), (4, 4), (3, 16), (6, 32), (12, MOST_EFFORT))
        for level in range(num_margins)
    ]
    return stages


@dataclass(frozen=True)
class Search:
    """Clear curves for every agent by search.

    Attributes:
        levels: the roadmaps of the problem.
        efforts: only stages whose effort is between these two are gone through.
    """

    name: ClassVar = "search"
    levels: Levels
    efforts: tuple[int, int] = (SOON_EFFORT, MOST_EFFORT)

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Stage after stage, until one succeeds."""
        problem = self.levels.problem
        paths = [path for path in problem.paths if path is not None]
        margins = margin_ladder(problem.scene.seeding.margin)
        if len(paths) == problem.num_agents:
            record = SeedRecord(margin=margins[0], tries=0)
            return SeedAttempt(f"{self.name} (prescribed paths)", paths, clear=True, record=record)
        ruled_out = self.levels.ruled_out
        reasons: tuple[Reason, ...] = ()
        tries = 0
        for number, stage in enumerate(schedule(len(margins))):
            margin = margins[stage.level]
            if margin in ruled_out or not self.efforts[0] <= stage.effort <= self.efforts[1]:
                continue
            if budget.spent():
                break
            level = self.levels.at(margin)
            if level.journeys.stranded():
                ruled_out[margin] = off_roadmap(level)
                reasons = reasons or ruled_out[margin]
                continue
            if budget.spent():
                break
            planner = level.planner(stage.layers)
            if planner.too_late():
                reasons = reasons or out_of_layers(planner)
                continue
            budget.progress(
                f"searching: margin {level.margin:g}, {planner.graph.num_vertices} vertices, "
                f"{planner.grid.count} layers"
            )
            rng = np.random.default_rng([budget.rng_seed, number])
            found = _run_stage(planner, stage, rng, budget)
            tries += found.tries
            if found.clear and not verify(problem, found.curves, planner.required):
                record = SeedRecord(margin=level.margin, tries=tries)
                return replace(found, found_by=f"{self.name} ({found.found_by})", record=record)
            reasons = found.reasons or reasons
            if any(reason.kind == "blocked" for reason in found.reasons):
                ruled_out[margin] = found.reasons
        reasons = reasons or next(iter(ruled_out.values()), ())
        return SeedAttempt(self.name, record=SeedRecord(tries=tries), reasons=reasons)


def _run_stage(
    planner: LayeredPlanner, stage: Stage, rng: np.random.Generator, budget: Budget
) -> SeedAttempt:
    """One stage: three planners and a joint search, each with an effort that grows with the stage's."""
    count = len(planner.movers)
    stopped = budget.spent
    # Hardly any order of a crowd works out, and its neighbourhoods take long to part.
    orders, rounds = (1, 10 * count) if count > CROWD else (5 + min(count, 10), 40 + 2 * count)
    ordered = plan_prioritized(planner, rng, stage.effort * orders, stopped)
    if ordered.clear:
        return ordered
    first = first_curves(planner, rng, stopped)
    if first is None:
        return ordered
    mended = replan_neighbourhoods(planner, first, rng, stage.effort * rounds, stopped)
    tries = ordered.tries + mended.tries
    if mended.clear:
        return mended.counting(tries)
    if count <= (MOST_PRIORITY_BASED if stage.effort > 2 else FEW_PRIORITY_BASED):
        max_nodes = 10 + count * stage.effort
        tree = plan_priority_based(planner, rng, 2 * stage.effort, max_nodes, stopped)
        tries += tree.tries
        if tree.clear:
            return tree.counting(tries)
    group = _group(planner, mended.touching)
    # More layers do not help the joint search: once a margin.
    once = (1, 1) if count <= MOST_AGENTS else (2, 2)
    if group and (stage.layers, stage.effort) == once:
        joint = plan_jointly(planner, group, rng, stopped)
        tries += 1
        if joint.curves is not None:
            return SeedAttempt("joint", joint.curves, clear=True).counting(tries)
        if joint.impossible:
            reasons = no_way_past(planner.problem, group, planner.graph.num_vertices)
            return SeedAttempt("joint", reasons=reasons).counting(tries)
    reasons = touching(planner.problem, mended.curves, mended.touching)
    return replace(mended, reasons=reasons).counting(tries)


def _group(planner: LayeredPlanner, pairs: Sequence[tuple[int, int]]) -> list[int]:
    """Two or three agents that block each other, for a joint search; none if there are more."""
    group: list[int] = []
    for pair in pairs:
        group += [agent for agent in pair if agent not in group]
    if 2 <= len(planner.movers) <= MOST_AGENTS:
        group = list(planner.movers)
    small = 2 <= len(group) <= MOST_AGENTS
    return group if small and set(group) <= set(planner.movers) else []
