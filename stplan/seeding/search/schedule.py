"""Seeding by search: roadmap, reservations and a schedule of planners, cheap ones first.

A stage is a margin and a number of layers; on each, prioritised planning, priority-based search
and the repair of neighbourhoods get counted efforts. Stages run from the margin asked for to
ever smaller ones, from few layers to many (a queue at a door needs more of them than the way is
long), and again with more effort until one succeeds or the time limit is hit. Nothing but that
limit depends on the clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.compiled import working_time
from stplan.problem.clearance import Requirement, held_requirement, requirement, verify
from stplan.problem.planning_problem import PlanningProblem
from stplan.reasons import Reason
from stplan.scene.model import SeedingSettings
from stplan.seeding.infeasibility import (
    no_way_past,
    not_connected,
    stranded,
    too_few_layers,
    touching,
)
from stplan.seeding.search.joint import MOST_AGENTS, plan_jointly
from stplan.seeding.search.large_neighbourhood import first_curves, repair
from stplan.seeding.search.planner import (
    Journeys,
    LayeredPlanner,
    automatic_layers,
)
from stplan.seeding.search.prioritized import plan_prioritized
from stplan.seeding.search.priority_based import plan_priority_based
from stplan.seeding.search.roadmap import build_roadmap

Progress = Callable[[str], None]

# Margins tried where the one asked for leaves no way.
SMALLER_MARGINS = (1.02, 1.005, 1.001)
# Priority-based search grows slow with the number of agents; beyond a few it comes late.
FEW_PRIORITY_BASED = 12
MOST_PRIORITY_BASED = 40
# Margins and multiples of the layers with which given curves are repaired.
REPAIR_STAGES = ((1.02, 1), (1.02, 2), (1.001, 2), (1.001, 4))
REPAIR_ITERATIONS = 60
# Stages of this effort are soon gone through; then other parts of a portfolio may have their turn.
SOON_EFFORT, MOST_EFFORT = 1, 128
LEAST_HELD = 1.0005


@dataclass(frozen=True)
class Stage:
    """One step of the schedule: index of the margin, multiple of the layers, effort of planners."""

    level: int
    layers: int
    effort: int


@dataclass(frozen=True)
class SearchResult:
    """What the search found.

    Attributes:
        curves: one clear (n, 3) curve an agent, or None.
        part: the planner that found them, "" if none did.
        margin: the margin they hold (what fixed ends leave of it).
        tries: orders, nodes and neighbourhoods tried in all.
        diagnosis: why nothing was found; empty where something was.
    """

    curves: list[FloatArray] | None
    part: str
    margin: float
    tries: int
    diagnosis: tuple[Reason, ...]


class _Level:
    """Everything that depends on the margin alone."""

    def __init__(self, problem: PlanningProblem, margin: float, refine: float) -> None:
        self.margin = margin
        # Set once it is known that this margin's roadmap has no solution.
        self.hopeless = False
        self.required: Requirement = requirement(problem, margin)
        self.movers = [int(agent) for agent in np.flatnonzero(~problem.prescribed)]
        heeding = problem.heeds_walls[self.movers]
        radii = self.required.walls[self.movers]
        roadmap = build_roadmap(
            problem.free_space,
            np.vstack(problem.stops),
            radii[heeding] if heeding.any() else radii,
            ignores_walls=not heeding.all(),
            refine=refine,
            around=4.0 * float(problem.distance.max()),
        )
        self.graph = roadmap.graph
        self.journeys = Journeys(problem, roadmap.graph, roadmap.place_of, self.required)


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


def search_curves(
    problem: PlanningProblem,
    *,
    settings: SeedingSettings,
    progress: Progress | None = None,
    efforts: tuple[int, int] = (1, MOST_EFFORT),
) -> SearchResult:
    """Clear curves for every agent by search, or why there are none.

    Uses `margin`, `layers`, `time_limit` and `rng_seed` of `settings`; only stages whose effort is
    between the two `efforts` are gone through.
    """
    say = progress or (lambda line: None)
    deadline = working_time() + settings.time_limit

    def stopped() -> bool:
        return working_time() > deadline

    given = [path for path in problem.paths if path is not None]
    if len(given) == problem.num_agents:
        return SearchResult(given, "given paths", settings.margin, 0, ())
    margins = [settings.margin, *(m for m in SMALLER_MARGINS if m < settings.margin)]
    levels: list[_Level | None] = [None] * len(margins)
    reasons: tuple[Reason, ...] = ()
    tries = 0
    for number, stage in enumerate(schedule(len(margins))):
        if not efforts[0] <= stage.effort <= efforts[1]:
            continue
        if stopped():
            break
        level = levels[stage.level]
        if level is None:
            level = _connected_level(problem, margins[stage.level])
            levels[stage.level] = level
        if level.journeys.stranded():
            reasons = reasons or stranded(problem, level.journeys.stranded(), level.margin)
            level.hopeless = True
        if all(known is not None and known.hopeless for known in levels):
            break
        if level.hopeless:
            continue
        if stopped():
            break
        count = settings.layers or automatic_layers(problem, level.graph, level.journeys)
        planner = LayeredPlanner(
            problem, level.graph, level.journeys, level.required, count * stage.layers
        )
        if planner.too_late():
            reasons = reasons or too_few_layers(problem, planner.too_late(), planner.grid.count)
            continue
        say(
            f"searching: margin {level.margin:g}, {planner.graph.num_vertices} vertices, "
            f"{planner.grid.count} layers"
        )
        rng = np.random.default_rng([settings.rng_seed, number])
        attempt = _run_stage(planner, stage, rng, stopped)
        tries += attempt.tries
        if attempt.curves is not None and not verify(problem, attempt.curves, planner.required):
            return SearchResult(attempt.curves, attempt.part, level.margin, tries, ())
        reasons = attempt.reasons or reasons
        level.hopeless = attempt.impossible
    return SearchResult(None, "", settings.margin, tries, reasons)


def repair_curves(
    problem: PlanningProblem,
    curves: Sequence[FloatArray],
    *,
    settings: SeedingSettings,
    progress: Progress | None = None,
) -> SearchResult:
    """Replan the neighbourhoods of `curves` in which pairs still touch, the others reserved.

    For curves of any origin, say a relaxation that left a few pairs stuck; each must be clear of
    the walls and meet its ends. Agents that are not replanned keep their curves. Pairs that
    hold less than the margin need not hold more than they do.
    """
    say = progress or (lambda line: None)
    deadline = working_time() + settings.time_limit
    reasons: tuple[Reason, ...] = ()
    tries = 0
    for number, (margin, layers) in enumerate(REPAIR_STAGES):
        level = _connected_level(problem, min(margin, settings.margin))
        if level.journeys.stranded():
            reasons = reasons or stranded(problem, level.journeys.stranded(), level.margin)
            continue
        count = settings.layers or automatic_layers(problem, level.graph, level.journeys)
        held = held_requirement(problem, curves, level.margin)
        # Less than this counts as touching: such pairs are replanned.
        floor = np.minimum(level.required.rods, LEAST_HELD * problem.distance)
        required = Requirement(np.maximum(held.rods, floor), level.required.walls)
        planner = LayeredPlanner(problem, level.graph, level.journeys, required, count * layers)
        if planner.too_late():
            reasons = reasons or too_few_layers(problem, planner.too_late(), planner.grid.count)
            continue
        say(f"repairing: {planner.graph.num_vertices} vertices, {planner.grid.count} layers")
        rng = np.random.default_rng([settings.rng_seed, number])
        mended = repair(planner, curves, rng, REPAIR_ITERATIONS, lambda: working_time() > deadline)
        tries += mended.iterations
        if mended.conflicts == 0 and not verify(problem, mended.curves):
            return SearchResult(mended.curves, "repair", level.margin, tries, ())
        reasons = touching(problem, mended.curves, mended.touching)
        if working_time() > deadline:
            break
    return SearchResult(None, "", settings.margin, tries, reasons)


def _connected_level(problem: PlanningProblem, margin: float) -> _Level:
    """The roadmap of a margin; finer where the first one misses ways that the free space has."""
    level = _Level(problem, margin, 1.0)
    if level.journeys.stranded() and not_connected(problem, level.required.walls):
        return level
    for refine in (2.0, 4.0):
        if not level.journeys.stranded():
            break
        level = _Level(problem, margin, refine)
    return level


@dataclass(frozen=True)
class _Attempt:
    """What one stage brought."""

    curves: list[FloatArray] | None
    part: str
    tries: int
    reasons: tuple[Reason, ...]
    impossible: bool = False


def _run_stage(
    planner: LayeredPlanner,
    stage: Stage,
    rng: np.random.Generator,
    stopped: Callable[[], bool],
) -> _Attempt:
    """One stage: three planners, each with an effort that grows with the stage's."""
    count = len(planner.movers)
    ordered = plan_prioritized(planner, rng, stage.effort * (5 + min(count, 10)), stopped)
    tries = ordered.tries
    if ordered.curves is not None:
        return _Attempt(ordered.curves, "prioritized", tries, ())
    ways = first_curves(planner, rng, stopped)
    if ways is None:
        return _Attempt(None, "", tries, ())
    mended = repair(planner, ways, rng, stage.effort * (40 + 2 * count), stopped)
    tries += mended.iterations
    if mended.conflicts == 0:
        return _Attempt(mended.curves, "repair", tries, ())
    if count <= (MOST_PRIORITY_BASED if stage.effort > 2 else FEW_PRIORITY_BASED):
        tree = plan_priority_based(
            planner, rng, 2 * stage.effort, 10 + count * stage.effort, stopped
        )
        tries += tree.nodes
        if tree.curves is not None:
            return _Attempt(tree.curves, "priority-based", tries, ())
    group = _group(planner, mended.touching)
    # More layers do not help the joint search: once a margin.
    once = (1, 1) if count <= MOST_AGENTS else (2, 2)
    if group and (stage.layers, stage.effort) == once:
        joint = plan_jointly(planner, group, rng, stopped)
        tries += 1
        if joint.curves is not None:
            return _Attempt(joint.curves, "joint", tries, ())
        if joint.impossible:
            return _Attempt(None, "", tries, no_way_past(planner, group), impossible=True)
    return _Attempt(None, "", tries, touching(planner.problem, mended.curves, mended.touching))


def _group(planner: LayeredPlanner, pairs: Sequence[tuple[int, int]]) -> list[int]:
    """Two or three agents that block each other, for a joint search; none if there are more."""
    group: list[int] = []
    for pair in pairs:
        group += [agent for agent in pair if agent not in group]
    if 2 <= len(planner.movers) <= MOST_AGENTS:
        group = list(planner.movers)
    small = 2 <= len(group) <= MOST_AGENTS
    return group if small and set(group) <= set(planner.movers) else []
