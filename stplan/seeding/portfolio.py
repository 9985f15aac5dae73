"""Initial curves by a portfolio of two families, each falling back on the other.

In the open, relaxation: straight rods pushed apart, no search. In tight spaces, search on a roadmap.
`method: auto` starts with relaxation where every agent's straight way is clear of the walls or radii
are many, and with search elsewhere; pairs that relaxation leaves touching are repaired by search, and
what search found is relaxed, because it queues more than it has to. `method: dijkstra` is the paper's
own. Whatever found them, curves are polished, given their knots, and proven clear.

All parts share one time limit. Efforts are counted, so it never decides which curves are found, only
whether any are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.compiled import working_time
from stplan.errors import SeedingError
from stplan.problem.clearance import verify, wall_clearance
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.reasons import Reason
from stplan.scene.model import Scene, SeedingSettings
from stplan.seeding.elastic_bands.geodesics import geodesic_curves
from stplan.seeding.elastic_bands.relaxation import RelaxationResult, relax
from stplan.seeding.elastic_bands.tightening import smooth_curves
from stplan.seeding.infeasibility import hopeless, not_connected, touching
from stplan.seeding.rendezvous import Rendezvous, with_rendezvous
from stplan.seeding.search.schedule import (
    MOST_EFFORT,
    SOON_EFFORT,
    SearchResult,
    repair_curves,
    search_curves,
)
from stplan.seeding.search.sequential_dijkstra import dijkstra_curves
from stplan.seeding.seeder import SeedRecord
from stplan.seeding.shortcutting.shortcuts import prepare_seed
from stplan.seeding.time_bounds import out_of_time
from stplan.world import FreeSpace, build_seeding_mesh

# A map this many times as large as what surrounds the agents is cut down to that for the search: their
# bounding box and as much on every side, or so many radii where they hardly move.
SPACIOUS = 16.0
SURROUNDINGS_RADII = 20.0
Progress = Callable[[str], None]

# Knots of a string while it relaxes.
RELAXATION_KNOTS = 40
# Sweeps before search takes over: in tight places soon, in the open late.
TIGHT_SWEEPS, OPEN_SWEEPS, MOST_SWEEPS = 400, 1500, 4000
# Search needs a table of reservations for every radius: of more radii than this relaxation goes first.
FEW_RADII = 3
# Search repairs what relaxation left where no more than this part of the agents touch, or so many pairs.
REPAIRED_PART, REPAIRED_PAIRS = 0.1, 4
# Polish may take this part of the time limit over it.
POLISH_TIME = 0.1


@dataclass(frozen=True)
class Seed:
    """Initial curves, proven clear.

    Attributes:
        found_by: the part of the portfolio that found them.
        record: repeatable figures of the search, for the report.
        rendezvous: places that the curves pass so that pairs meet there, at any times.
    """

    world_lines: WorldLines
    found_by: str
    record: SeedRecord = field(default_factory=SeedRecord)
    rendezvous: tuple[Rendezvous, ...] = ()


@dataclass
class _Portfolio:
    """The parts with what they share, and what has been tried so far."""

    scene: Scene
    problem: PlanningProblem
    progress: Progress
    deadline: float
    curves: list[FloatArray] | None = None
    found_by: str = ""
    record: SeedRecord = field(default_factory=SeedRecord)
    reasons: list[Reason] = field(default_factory=list)

    def settings(self) -> SeedingSettings:
        """The scene's settings with the time that is left."""
        left = max(self.deadline - working_time(), 0.0)
        return replace(self.scene.seeding, time_limit=left)

    def relax(self, max_sweeps: int) -> None:
        """Relaxation; where few pairs are left touching, search repairs them."""
        settings = self.settings()
        ways = None
        if not _straight_ways_are_clear(self.problem):
            found = geodesic_curves(self.problem)
            ways = [way for way in found if way is not None]
            if len(ways) < len(found):
                self.reasons += [
                    Reason("no way", (name,))
                    for name, way in zip(self.problem.agent_ids, found, strict=True)
                    if way is None
                ]
                return
        self.progress("seeding by relaxation")
        result = relax(
            self.problem,
            ways,
            num_knots=self.scene.solver.knots or RELAXATION_KNOTS,
            margin=settings.margin,
            time_limit=settings.time_limit,
            rng_seed=settings.rng_seed,
            max_sweeps=max_sweeps,
        )
        self.record = SeedRecord(sweeps=result.sweeps, retensions=result.retensions)
        if result.solved:
            self.curves, self.found_by = result.curves, "relaxation"
            return
        self.reasons += _left_touching(self.problem, result)
        if settings.method == "auto":
            self._repair(result)

    def _repair(self, result: RelaxationResult) -> None:
        """Search for other curves where a relaxation is stuck, if that is in few places."""
        touching = {agent for pair in result.stuck for agent in pair}
        few = len(result.stuck) <= REPAIRED_PAIRS
        few = few or len(touching) <= REPAIRED_PART * self.problem.num_agents
        if not few or not result.stuck or self.settings().time_limit <= 0.0:
            return
        self.progress("repairing by search")
        mended = repair_curves(
            self.problem, result.curves, settings=self.settings(), progress=self.progress
        )
        if mended.curves is not None:
            self.curves, self.found_by = mended.curves, "relaxation, repaired"
            self.record = replace(self.record, margin=mended.margin, tries=mended.tries)

    def search(self, least_effort: int, most_effort: int) -> None:
        """Search on a roadmap, its stages of some efforts."""
        settings = self.settings()
        if settings.time_limit <= 0.0:
            return
        result = search_curves(
            self.problem, settings=settings, progress=self.progress,
            efforts=(least_effort, most_effort),
        )  # fmt: skip
        self._take(result, f"search ({result.part})")

    def dijkstra(self) -> None:
        """The paper's sequential search on the seeding mesh."""
        mesh = build_seeding_mesh(self.scene, self.problem.free_space)
        result = dijkstra_curves(
            self.problem, mesh, settings=self.settings(), progress=self.progress
        )
        self._take(result, "dijkstra")

    def _take(self, result: SearchResult, name: str) -> None:
        if result.curves is not None:
            self.curves, self.found_by = result.curves, name
            self.record = SeedRecord(margin=result.margin, tries=result.tries)
            return
        self.reasons += result.diagnosis

    def timed_out(self) -> bool:
        """Whether the time limit has struck."""
        return working_time() > self.deadline


def find_seed(
    problem: PlanningProblem, *, progress: Progress, settings: SeedingSettings | None = None
) -> Seed:
    """Clear initial curves for every agent, found as `settings` say (default: as the scene does).

    Raises:
        SeedingError: none were found; its reasons say whom it concerns, and whether that is proven.
    """
    scene = problem.scene
    if settings is not None:
        scene = replace(scene, seeding=settings)
    limit = scene.seeding.time_limit
    deadline = working_time() + limit
    problem, rendezvous = with_rendezvous(replace(problem, scene=scene))
    reasons = hopeless(problem) or out_of_time(problem)
    if reasons:
        raise SeedingError(reasons)
    portfolio = _Portfolio(scene, _surroundings(problem), progress, deadline)
    for part in _parts(portfolio):
        part()
        if portfolio.curves is not None or portfolio.timed_out():
            break
    if portfolio.curves is None:
        found = portfolio.reasons
        if portfolio.timed_out() or not found:
            found.append(Reason("time limit", figures={"limit": limit}))
        raise SeedingError(found)
    curves = _prepared(portfolio, deadline + POLISH_TIME * limit)
    faults = verify(problem, curves)
    if faults:
        raise SeedingError("initial curves are not clear: " + "; ".join(faults))
    progress(f"seed found by {portfolio.found_by}")
    lines = WorldLines.from_curves(problem.agent_ids, curves)
    return Seed(lines, portfolio.found_by, portfolio.record, rendezvous)


def _surroundings(problem: PlanningProblem) -> PlanningProblem:
    """The problem, its map cut down to the surroundings of the agents where it is far wider than their ways.

    A roadmap of the whole would be coarse where agents move, and take long elsewhere.
    """
    space = problem.free_space
    if space is None:
        return problem
    places = np.vstack(problem.stops)
    low, high = places.min(axis=0), places.max(axis=0)
    room = max(float((high - low).max()), SURROUNDINGS_RADII * float(problem.radii.max()))
    box = shapely.box(*(low - room), *(high + room))
    if space.polygon.area < SPACIOUS * box.area:
        return problem
    part = FreeSpace.from_polygon(shapely.intersection(space.polygon, box))
    near = replace(problem, free_space=part)
    return problem if not_connected(near, problem.radii) else near


def _prepared(portfolio: _Portfolio, deadline: float) -> list[FloatArray]:
    """The curves that were found, relaxed on where search found them, polished and evened out.

    Raises:
        SeedingError: that was not done by the `deadline`.
    """
    scene, problem = portfolio.scene, portfolio.problem

    def check() -> None:
        if working_time() > deadline:
            limit = scene.seeding.time_limit
            raise SeedingError([Reason("unprepared", figures={"limit": limit})])

    curves: Sequence[FloatArray] = portfolio.curves or []
    settings = scene.seeding
    if settings.method != "dijkstra" and portfolio.found_by != "relaxation":
        curves = smooth_curves(
            problem, curves, margin=settings.margin, rng_seed=settings.rng_seed, check=check
        )
    return prepare_seed(
        problem, curves, scene.solver.knots, settings.margin, settings.rng_seed, check
    )


def _parts(portfolio: _Portfolio) -> list[Callable[[], None]]:
    """Parts of the portfolio in the order they are tried."""
    method = portfolio.scene.seeding.method
    if method == "dijkstra":
        return [portfolio.dijkstra]
    if method == "relaxation":
        return [lambda: portfolio.relax(MOST_SWEEPS)]
    if method == "search":
        return [lambda: portfolio.search(SOON_EFFORT, MOST_EFFORT)]
    many_radii = len(np.unique(portfolio.problem.radii)) > FEW_RADII
    if many_radii or _straight_ways_are_clear(portfolio.problem):
        return [
            lambda: portfolio.relax(OPEN_SWEEPS),
            lambda: portfolio.search(SOON_EFFORT, MOST_EFFORT),
        ]
    return [
        lambda: portfolio.search(SOON_EFFORT, SOON_EFFORT),
        lambda: portfolio.relax(TIGHT_SWEEPS),
        lambda: portfolio.search(SOON_EFFORT + 1, MOST_EFFORT),
    ]


def _left_touching(problem: PlanningProblem, result: RelaxationResult) -> tuple[Reason, ...]:
    """What relaxation could not part."""
    if result.stuck:
        return touching(problem, result.curves, result.stuck)
    return (Reason("walls"),)


def _straight_ways_are_clear(problem: PlanningProblem) -> bool:
    """Whether walls leave every agent its straight way through its waypoints."""
    for agent in range(problem.num_agents):
        stops = np.vstack([problem.starts[agent], problem.waypoints[agent], problem.goals[agent]])
        way = np.column_stack([stops, np.arange(len(stops))])
        if wall_clearance(problem, agent, way) <= problem.radii[agent]:
            return False
    return True
