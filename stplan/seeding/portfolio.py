"""Initial curves by a portfolio of two families, each falling back on the other.

In the open, relaxation: straight rods pushed apart, no search. In tight spaces, search on a roadmap.
`method: auto` starts with relaxation where every agent's straight way is clear of the walls or radii
are many, and with search elsewhere; where relaxation leaves few pairs touching, large-neighbourhood search
replans them, and what search found is relaxed, because it queues more than it has to. Any other method is one
seeder alone, `dijkstra` the paper's own. Whatever found them, curves are shortened, given their knots, and
proven clear.

All seeders share one time limit. Efforts are counted, so it never decides which curves are found, only
whether any are. Whatever takes long looks at the clock as it goes (`stplan.deadline`), so that all ends soon
after the limit.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.callbacks import Progress
from stplan.compiled import working_time
from stplan.deadline import OutOfTimeError, until
from stplan.errors import SeedingError
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement, requirement
from stplan.problem.verification import verify
from stplan.problem.world_lines import WorldLines
from stplan.reasons import Reason
from stplan.scene.model import SeedingSettings
from stplan.seeding.elastic_bands.relaxation_seeder import Relaxation, straight_ways_are_clear
from stplan.seeding.elastic_bands.tightening import tighten
from stplan.seeding.infeasibility import hopeless, not_connected
from stplan.seeding.registry import SEEDERS
from stplan.seeding.remedies import remedies
from stplan.seeding.rendezvous import Rendezvous, with_rendezvous
from stplan.seeding.search.emptying import Emptying
from stplan.seeding.search.joint_search import JointSearch
from stplan.seeding.search.least_cost import LeastCost
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.mending import Mending
from stplan.seeding.search.schedule import MOST_EFFORT, SOON_EFFORT, Search
from stplan.seeding.search.sequential_dijkstra import SequentialDijkstra
from stplan.seeding.seeder import Budget, SeedAttempt, Seeder, SeedRecord
from stplan.seeding.shortcutting.compression import arriving_as, compressed
from stplan.seeding.shortcutting.shortcuts import prepare_seed, resample
from stplan.seeding.time_bounds import out_of_time

# The method that chooses among the others.
AUTO = "auto"
# A map this many times as large as what surrounds the agents is cut down to that for the search: their
# bounding box and as much on every side, or so many radii where they hardly move.
SPACIOUS = 16.0
SURROUNDINGS_RADII = 20.0
# Sweeps before search takes over: in tight places soon, in the open late.
TIGHT_SWEEPS, OPEN_SWEEPS = 400, 1500
# Search needs a table of reservations for every radius: of more radii than this relaxation goes first.
FEW_RADII = 3
# What relaxation left is mended where no more than this part of the agents touch, or so many pairs.
MENDED_PART, MENDED_PAIRS = 0.1, 4
# Starts of relaxation as a rival in tight spaces: they are quick, and differ little.
RELAXATION_STARTS = 10
# Starts of search, besides the first, where cheapest ways and relaxation lead to hardly any class.
SEARCHES = 2
# Of more agents relaxation is the first rival: soon it says whether there is no room for any of them.
CROWDED = 24
# In larger crowds between walls rivals hardly ever find a way, and take half of the time to fail.
MOST_COMPETING = 110
# Preparing what was found may take this part of the time limit over it; a tenth with its last step.
PREPARATION_TIME = 0.07


@dataclass(frozen=True)
class Seed:
    """Initial curves, proven clear.

    Attributes:
        found_by: the seeder that found them.
        record: repeatable figures of the search, for the report.
        rendezvous: places that the curves pass so that pairs meet there, at any times.
    """

    world_lines: WorldLines
    found_by: str
    record: SeedRecord = field(default_factory=SeedRecord)
    rendezvous: tuple[Rendezvous, ...] = ()


@dataclass(frozen=True)
class MendedRelaxation:
    """Relaxation; where it leaves few pairs touching, large-neighbourhood search replans them."""

    relaxation: Relaxation
    mending: Mending

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Relax, then mend."""
        found = self.relaxation.attempt(budget)
        if found.clear or not self._worth_mending(found) or budget.spent():
            return found
        mended = self.mending.attempt_from(found.curves, budget)
        if not mended.clear:
            return found
        record = replace(found.record, margin=mended.record.margin, tries=mended.record.tries)
        return replace(mended, found_by=f"{found.found_by}, repaired", record=record)

    def _worth_mending(self, found: SeedAttempt) -> bool:
        """Whether there are few places that touch."""
        agents = {agent for pair in found.touching for agent in pair}
        few = len(found.touching) <= MENDED_PAIRS
        few = few or len(agents) <= MENDED_PART * self.relaxation.problem.num_agents
        return few and bool(found.touching)


@dataclass(frozen=True)
class Rival:
    """A seeder whose seeds compete with others.

    Attributes:
        starts: how many of it a scene is worth.
        patience: how many in a row may fail, or be far too dear, before it is asked no more; less of them
            that take long.
        spare: whether it found the first seed maybe, and is asked for others where there are few classes.
    """

    seeder: Seeder
    starts: int
    patience: int
    spare: bool = False


@dataclass(frozen=True)
class Portfolio:
    """A problem made ready for seeding again and again: all that random numbers do not change.

    Attributes:
        problem: what curves have to satisfy, rendezvous among the waypoints.
        rendezvous: where pairs meet that have to.
        required: what the margin asks for.
        seeders: in the order they are tried.
        rivals: whose seeds compete with the first one found, in tight spaces.
        levels: the roadmaps that those seeds are improved on; None where nothing competes.
    """

    problem: PlanningProblem
    rendezvous: tuple[Rendezvous, ...]
    required: Requirement
    seeders: tuple[Seeder, ...]
    rivals: tuple[Rival, ...] = ()
    levels: Levels | None = None

    def find(self, budget: Budget) -> Seed:
        """Clear initial curves by the first seeder that finds any.

        Raises:
            SeedingError: none did.
        """
        return self.seed(self.first_clear(budget), budget)

    def seed(self, found: SeedAttempt, budget: Budget) -> Seed:
        """A seed of the clear curves that were found.

        Raises:
            SeedingError: it was not prepared in time, or not clear after all.
        """
        curves = self._prepared(found, budget)
        faults = verify(self.problem, curves)
        if faults:
            reasons = [Reason("not clear", fault.agents) for fault in faults]
            raise SeedingError(reasons)
        budget.progress(f"seed found by {found.found_by}")
        lines = WorldLines.from_curves(self.problem.agent_ids, curves)
        return Seed(lines, found.found_by, found.record, self.rendezvous)

    def first_clear(self, budget: Budget) -> SeedAttempt:
        """What the first seeder found that finds any, not yet prepared.

        Raises:
            SeedingError: none did.
        """
        reasons: list[Reason] = []
        for seeder in self.seeders:
            found = attempted(seeder, budget)
            if found.clear:
                return found
            reasons += found.reasons
            if budget.spent():
                break
        late = budget.spent() or not reasons
        reasons += remedies(self.problem, reasons)
        if late:
            reasons.append(out_of_limit(self.problem))
        raise SeedingError(reasons)

    @property
    def _time_limit(self) -> float:
        return self.problem.scene.seeding.time_limit

    def _prepared(self, found: SeedAttempt, budget: Budget) -> list[FloatArray]:
        """The curves that were found, tightened where search found them, shortened and retimed."""
        settings = self.problem.scene.seeding
        if not settings.shortcuts:
            return resample(self.problem, found.curves, self.problem.scene.solver.knots)
        budget = replace(budget, deadline=budget.deadline + PREPARATION_TIME * settings.time_limit)
        curves, problem = found.curves, self.problem
        hasty = problem.scene.minimise != "energy"
        with until(budget.deadline):
            if hasty:
                problem = arriving_as(problem, curves)
            elif settings.method != SequentialDijkstra.name and found.found_by != Relaxation.name:
                curves = tighten(problem, curves, self.required, rng_seed=budget.rng_seed)
            curves = prepare_seed(
                problem, curves, self.required,
                num_knots=problem.scene.solver.knots, rng_seed=budget.rng_seed,
            )  # fmt: skip
        if budget.spent():
            raise SeedingError([Reason("unprepared", figures={"limit": self._time_limit})])
        return compressed(problem, curves) if hasty else curves


def attempted(seeder: Seeder, budget: Budget) -> SeedAttempt:
    """What a seeder finds until the deadline of `budget`."""
    with until(budget.deadline):
        try:
            return seeder.attempt(budget)
        except OutOfTimeError:
            return SeedAttempt(type(seeder).__name__)


def out_of_limit(problem: PlanningProblem) -> Reason:
    """That nothing was found within the time limit."""
    return Reason("time limit", figures={"limit": problem.scene.seeding.time_limit})


def find_seed(
    problem: PlanningProblem, *, progress: Progress, settings: SeedingSettings | None = None
) -> Seed:
    """Clear initial curves for every agent, found as `settings` say (default: as the scene does).

    Raises:
        SeedingError: none were found; its reasons say whom it concerns, and whether that is proven.
    """
    if settings is not None:
        problem = replace(problem, scene=replace(problem.scene, seeding=settings))
    settings = problem.scene.seeding
    deadline = working_time() + settings.time_limit
    portfolio = prepare_portfolio(problem, deadline)
    return portfolio.find(Budget(settings.rng_seed, deadline, progress))


def prepare_portfolio(
    problem: PlanningProblem, deadline: float = float("inf"), *, contested: bool = False
) -> Portfolio:
    """What all seeding of `problem` shares, made until `deadline` (s of `working_time`).

    Args:
        contested: whether others compete with relaxation where straight ways are clear of the walls.

    Raises:
        SeedingError: it is proven that there are no curves, or the deadline has passed.
    """
    with until(deadline):
        try:
            return _portfolio(problem, contested)
        except OutOfTimeError as error:
            raise SeedingError([out_of_limit(problem)]) from error


def _portfolio(problem: PlanningProblem, contested: bool) -> Portfolio:
    problem, rendezvous = with_rendezvous(problem)
    reasons = hopeless(problem) or out_of_time(problem)
    if reasons:
        raise SeedingError(reasons)
    problem = _surroundings(problem)
    method, levels = problem.scene.seeding.method, Levels(problem)
    many_radii = len(np.unique(problem.radii)) > FEW_RADII
    if method == AUTO and (many_radii or straight_ways_are_clear(problem)):
        relaxation = Relaxation(problem, OPEN_SWEEPS, levels)
        mended = MendedRelaxation(relaxation, Mending(levels))
        opened = Portfolio(
            problem, rendezvous, relaxation.required, (mended, JointSearch(levels), Search(levels))
        )
        if many_radii or not contested:
            return opened
        soon = Rival(Search(levels, (SOON_EFFORT, SOON_EFFORT)), 1, patience=1)
        return replace(opened, rivals=(soon, *_rivals(levels, relaxation)), levels=levels)
    required = requirement(problem, problem.scene.seeding.margin)
    if method != AUTO:
        return Portfolio(problem, rendezvous, required, (SEEDERS[method](problem),))
    seeders, rivals = _tight_seeders(levels)
    return Portfolio(problem, rendezvous, required, seeders, rivals, levels)


def _surroundings(problem: PlanningProblem) -> PlanningProblem:
    """The problem, its map cut down to what surrounds the agents where it is far wider than their ways.

    A roadmap of the whole would be coarse where agents move, and take long elsewhere.
    """
    space = problem.free_space
    if space is None:
        return problem
    import shapely

    places = np.vstack(problem.stops)
    if not len(places):
        return problem
    low, high = places.min(axis=0), places.max(axis=0)
    room = max(float((high - low).max()), SURROUNDINGS_RADII * float(problem.radii.max()))
    box = shapely.box(*(low - room), *(high + room))
    if space.polygon.area < SPACIOUS * box.area:
        return problem
    part = space.within(box)
    near = replace(problem, free_space=part)
    return problem if not_connected(near, problem.radii) else near


def _tight_seeders(levels: Levels) -> tuple[tuple[Seeder, ...], tuple[Rival, ...]]:
    """The seeders in the order they are tried in tight spaces, and what competes with them."""
    relaxation = Relaxation(levels.problem, TIGHT_SWEEPS, levels)
    emptying, search = Emptying(levels), Search(levels, (SOON_EFFORT, SOON_EFFORT))
    # A large crowd of which all stay leaves no floor behind that empties.
    staying = levels.problem.num_agents > MOST_COMPETING and bool(levels.problem.stays.all())
    seeders = (
        *((search, emptying) if staying else (emptying, search)),
        JointSearch(levels),
        MendedRelaxation(relaxation, Mending(levels)),
        Search(levels, (SOON_EFFORT + 1, MOST_EFFORT)),
    )
    if levels.problem.num_agents > MOST_COMPETING:
        return seeders, ()
    return seeders, _rivals(levels, relaxation)


def _rivals(levels: Levels, relaxation: Relaxation) -> tuple[Rival, ...]:
    """Whose seeds compete with the first one found, in the order they are asked."""
    by_motion, by_length = LeastCost(levels), LeastCost(levels, by_length=True)
    searches = (
        Rival(by_motion, by_motion.worthwhile_starts, patience=1),
        Rival(by_length, by_length.worthwhile_starts, patience=1),
    )
    again = Rival(Search(levels, (SOON_EFFORT, SOON_EFFORT)), SEARCHES, patience=1, spare=True)
    relaxations = (Rival(relaxation, RELAXATION_STARTS, patience=2),)
    if levels.problem.num_agents > CROWDED:
        return (*relaxations, *searches, again)
    return (*searches, *relaxations, again)
