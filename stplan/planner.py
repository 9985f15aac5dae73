"""The whole story: prepare -> seed -> restore -> certify -> optimise -> certify -> write.

Every stage is a function of the prepared problem and of what the stage before it gave. Curves are found in
the local frame of the problem, and certified and written in the user's coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING

from stplan.analysis.arrival_gap import arrival_gap
from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.metrics import metrics
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.certify.certificate import Certificate, certify
from stplan.clock import Clock
from stplan.compiled import compiled_before, working_time
from stplan.errors import BrokenSeedError, SeedingError, StoppedError, UsageError
from stplan.geometry.rod_distances import segment_distances
from stplan.hastening import arrivals_of, hasten, with_ample_horizon
from stplan.improved_plan import OTHER_MOVES, improved_plan
from stplan.improvement.budget import ImprovementBudget
from stplan.multistart import best_seeds
from stplan.nlp.ipopt.adapter import require_options
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.optimize.cluster_workers import on_cluster
from stplan.optimize.continuation import LiveLine, Optimisation
from stplan.optimize.restoration import restore
from stplan.optimize.rivals import optimise_rival
from stplan.optimize.whole import optimise_whole
from stplan.optimize.workers import WorkersFor, on_this_machine
from stplan.planned import Plan, cheapest, notes_of, plan_files, write_plan
from stplan.problem import planning_problem
from stplan.problem.ends import ending_as, fixed_at, lasting_as
from stplan.problem.metric import sharpened, with_metric
from stplan.problem.planning_problem import PlanningProblem, at_horizon, within
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import space_of
from stplan.punctuality import punctual_seeds
from stplan.report import OptimisationReport, OptimisationTimes, Report, RunRecord, SeedReport
from stplan.scene.model import Scene
from stplan.scene.moving_goals import is_play
from stplan.seeding.portfolio import Seed
from stplan.status import Status
from stplan.threads import threads

if TYPE_CHECKING:
    from distributed import Client

    from stplan.world import FreeSpace

__all__ = [
    "InitialCurves",
    "Plan",
    "check",
    "find_initial_curves",
    "improve",
    "plan",
    "plan_files",
    "prepare",
    "seed",
    "write_plan",
]

# Horizons that are open become so many times as long where nothing is found within them.
MORE_TIME = (3.0,)
# Who arrives within an earlier horizon than the scene's has this part of its trip to spare.
SPARE_TIME = 0.05


@dataclass(frozen=True)
class InitialCurves:
    """A seed that keeps all that the scene asks: from here on there is something to keep.

    Attributes:
        seed: its world lines are the restored ones, in the frame of the problem.
        world_lines: the same as the user's.
        certificate: of them; it holds.
        problem: what they were found for, maybe with an earlier horizon than the scene's.
        improvement: what the plan is to be improved for, as `ImprovementBudget.effort`.
    """

    seed: Seed
    world_lines: WorldLines
    certificate: Certificate
    problem: PlanningProblem
    improvement: float = 0.0


def plan(
    scene: Scene,
    *,
    progress: Progress | None = None,
    live: LiveLine | None = None,
    stop: Stop | None = None,
    num_workers: int = 1,
    cluster: Client | None = None,
) -> Plan:
    """Plan `scene`: find a seed, optimise it, certify the result.

    Args:
        progress: called with a line now and then.
        live: given a maker of a progress line after every iteration of Ipopt.
        stop: asked while there are curves to keep, after every iteration; True ends with the best
            feasible ones so far. `stplan.stopping` has one for handlers of signals.
        num_workers: processes that optimise blocks of many agents at the same time, forked off this one where
            the system can, and threads for other work; the plan is the same for any number.
        cluster: a client of a Dask cluster whose workers optimise the blocks instead.

    Raises:
        SceneError: the scene does not fit its map, or not into memory.
        SeedingError: no collision-free initial curves were found.
        SolverError: Ipopt lacks the linear solver or an option asked for.
        StoppedError: stopped before there were curves that keep all that the scene asks.
    """
    with threads(num_workers):
        workers = on_this_machine(num_workers) if cluster is None else on_cluster(cluster)
        return _plan(scene, progress or unheard, live, stop or never, workers)


def _plan(
    scene: Scene, progress: Progress, live: LiveLine | None, stop: Stop, workers: WorkersFor
) -> Plan:
    with (clock := Clock()).stage("world"):
        problem = prepare(scene, progress)
    problem, rivals = _begun(problem, progress=progress, stop=stop, clock=clock)
    stop()  # The answer is heeded below; who is asked knows that from here on a plan is certain.
    plans: list[Plan] = []
    for number, initial in enumerate(rivals, start=1):
        if plans and stop():
            break
        if len(rivals) > 1:
            progress(f"plan {number} of {len(rivals)}, from the seed by {initial.seed.found_by}")
        if plans:
            other = _rival(problem, initial, plans, stop=stop, clock=clock)
            plans += [] if other is None else [other]
            continue
        with clock.stage("optimise"):
            sharp, optimised = _optimised(
                problem, initial, progress=progress, live=live, stop=stop, workers=workers
            )
        plans.append(_planned(sharp, initial, optimised, clock))
    best = cheapest(plans)
    if rivals[0].improvement and not stop():
        budget = ImprovementBudget(effort=rivals[0].improvement)
        best = _improved(best, budget, OTHER_MOVES, clock, progress, live, stop)
    with clock.stage("bound"):
        lines = best.trajectories or best.seed
        if scene.minimise == "energy":
            content = replace(best.report, bound=cost_bound(problem, lines))
        else:
            content = replace(best.report, arrivals=arrival_gap(problem, lines))
            content = replace(content, scene=lasting_as(content.scene, lines))
    return replace(best, report=content, run=RunRecord.of(clock, best.run.optimisation))


def improve(
    result: Plan,
    budget: ImprovementBudget,
    *,
    progress: Progress | None = None,
    live: LiveLine | None = None,
    stop: Stop | None = None,
) -> Plan:
    """`result`, a plan with trajectories, with the cheapest ones that the moves of `budget` lead to.

    Never dearer, and certified; everybody ends where it did. `stop` ends with the best so far.
    """
    if result.trajectories is None:
        return result
    if result.status is Status.PLAYED:
        raise UsageError(f"{result.scene.name} was played: that is past improvement")
    clock = Clock()
    improved = _improved(result, budget, 0, clock, progress, live, stop or never)
    return replace(improved, run=result.run.and_then(clock))


def seed(scene: Scene, *, progress: Progress | None = None, stop: Stop | None = None) -> Plan:
    """Only the initial curves of `scene`, certified. Raises like `plan`."""
    clock = Clock()
    with clock.stage("world"):
        problem = prepare(scene, progress)
    scene = problem.written.scene
    (initial,) = find_initial_curves(problem, progress=progress, stop=stop, clock=clock)
    found = SeedReport.of(initial.seed, initial.world_lines, initial.certificate, scene)
    notes = notes_of(problem.written.free_space)
    content = Report(scene, Status.SEEDED, initial.certificate, found.metrics, found, notes=notes)
    return Plan(initial.world_lines, None, content, RunRecord.of(clock))


def check(scene: Scene, lines: WorldLines, *, progress: Progress | None = None) -> Certificate:
    """The certificate of any trajectories against `scene`.

    What the user has to know about the map is said through `progress`. Raises SceneError for a bad map.
    """
    scene = lasting_as(scene, lines)
    free_space = space_of(scene)
    _say_notes(scene, free_space, progress or unheard)
    return certify(scene, free_space, lines)


def prepare(scene: Scene, progress: Progress | None = None) -> PlanningProblem:
    """The problem of `scene` in its local frame; what may be refused without any work is refused here.

    Its own scene has a goal for everybody, also where that is a place or one of some points. What the user
    has to know about the map is said through `progress`.

    Raises:
        SceneError: the scene does not fit its map, or not into memory.
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """
    chosen_linear_solver(scene)
    require_options(scene.solver.ipopt)
    if scene.changes:
        raise UsageError(f"{scene.name} has events: `stplan solve` plans them, one after another")
    if is_play(scene):
        raise UsageError(
            f"{scene.name} has goals that move, perception or tasks: `stplan solve` plays it, round by round"
        )
    problem = planning_problem.prepare_local(scene)
    _say_notes(scene, problem.written.free_space, progress or unheard)
    if scene.assignments or any(agent.goal_places for agent in scene.agents):
        from stplan.seeding.assignment import settle_goals

        problem = settle_goals(problem)
    if scene.horizon_rule == "auto":
        problem = with_ample_horizon(problem)
    return with_metric(problem)


def _say_notes(scene: Scene, free_space: FreeSpace | None, progress: Progress) -> None:
    if free_space is not None:
        from stplan.world import warnings_of

        for line in warnings_of(scene, free_space):
            progress(line)


def find_initial_curves(
    problem: PlanningProblem,
    *,
    most: int | None = 1,
    progress: Progress | None = None,
    stop: Stop | None = None,
    clock: Clock | None = None,
) -> list[InitialCurves]:
    """The cheapest seeds found, made to keep the limits and times of the scene, and certified.

    At least one, at `most` so many (None: as many as the scene's effort asks for), the cheapest first.

    Raises:
        SeedingError: none was found; BrokenSeedError where none holds its certificate.
        StoppedError: `stop` said so before the limits were kept.
    """
    progress, stop, clock = progress or unheard, stop or never, clock or Clock()
    written = problem.written
    with clock.stage("seed"):
        if not compiled_before(segment_distances):
            progress("compiling, once after installation: this takes about a quarter of a minute")
        deadline = working_time() + problem.scene.seeding.time_limit
        contest = best_seeds(problem, progress=progress)
    earlier = [] if contest.horizon is None else [within(problem, contest.horizon)]
    found: list[InitialCurves] = []
    violations: tuple[str, ...] = ()
    late = punctual_seeds(problem, deadline, progress=progress, stop=lambda: bool(found) or stop())
    for seed in chain(contest.seeds, late):
        if len(found) == (most or contest.finalists) or (found and stop()):
            break
        for given in (*earlier, problem):
            with clock.stage("seed"):
                lines = restore(
                    given, seed.world_lines, seed.rendezvous, progress=progress, stop=stop
                )
                if lines is not seed.world_lines and not found and stop():
                    raise StoppedError
            with clock.stage("certify"):
                outside = written.outside(lines)
                certificate = certify(written.scene, written.free_space, outside)
            if certificate.holds:
                restored = replace(seed, world_lines=lines)
                found.append(
                    InitialCurves(restored, outside, certificate, given, contest.improvement)
                )
                break
        violations = violations or certificate.violations
    if not found:
        raise StoppedError if stop() else BrokenSeedError(violations)
    return found


def _begun(
    problem: PlanningProblem, *, progress: Progress, stop: Stop, clock: Clock
) -> tuple[PlanningProblem, list[InitialCurves]]:
    """Initial curves; where the horizon is open, with more time if there are none. Raises likewise."""
    horizon = problem.written.scene.horizon
    for more in MORE_TIME if problem.scene.horizon_rule == "auto" else ():
        try:
            return problem, find_initial_curves(problem, progress=progress, stop=stop, clock=clock)
        except SeedingError:
            progress(f"no initial curves within {problem.written.scene.horizon:.4g} s")
            problem = at_horizon(problem, more * horizon)
    curves = find_initial_curves(problem, most=None, progress=progress, stop=stop, clock=clock)
    return problem, curves


def _optimised(
    problem: PlanningProblem,
    initial: InitialCurves,
    *,
    progress: Progress,
    live: LiveLine | None,
    stop: Stop,
    workers: WorkersFor,
) -> tuple[PlanningProblem, Optimisation]:
    """The optimised curves, and the problem in the metric they were optimised in.

    An earlier horizon than the scene's is given up where somebody has a use for more time after all.
    """
    lines = initial.seed.world_lines
    if problem.scene.minimise != "energy":
        sharp = sharpened(problem, lines)
        return sharp, hasten(sharp, lines, progress=progress, live=live, stop=stop)
    for given in (initial.problem, problem):
        sharp = sharpened(given, lines)
        optimised = optimise_whole(
            sharp, lines, progress=progress, live=live, stop=stop, workers=workers
        )
        latest = arrivals_of(optimised.world_lines)
        spare = given.max_times - latest > SPARE_TIME * (latest - given.start_times)
        if given is problem or spare[~given.prescribed].all():
            break
    return sharp, optimised


def _rival(
    problem: PlanningProblem,
    initial: InitialCurves,
    plans: Sequence[Plan],
    *,
    stop: Stop,
    clock: Clock,
) -> Plan | None:
    """The plan from another seed, None where its optimisation tells that it is dearer than the best."""
    problem = sharpened(initial.problem, initial.seed.world_lines)
    reports = (plan.report.optimisation for plan in plans)
    known = [
        [done.objective for done in one.outer_iterations] for one in reports if one is not None
    ]
    with clock.stage("optimise"):
        optimised = optimise_rival(problem, initial.seed.world_lines, known, stop=stop)
    planned = None if optimised is None else _planned(problem, initial, optimised, clock)
    return None if planned is None or planned.status is Status.BROKEN else planned


def _improved(
    result: Plan,
    budget: ImprovementBudget,
    rng_shift: int,
    clock: Clock,
    progress: Progress | None,
    live: LiveLine | None,
    stop: Stop,
) -> Plan:
    """`result` with the cheapest trajectories that the moves of `budget` lead to."""
    with clock.stage("world"):
        problem = prepare(fixed_at(result.scene, result.trajectories or result.seed))
    with clock.stage("improve"):
        return improved_plan(
            result, problem, budget, rng_shift=rng_shift, progress=progress, live=live, stop=stop
        )


def _planned(
    problem: PlanningProblem,
    initial: InitialCurves,
    optimised: Optimisation,
    clock: Clock,
) -> Plan:
    """The optimised curves where they hold their certificate, else the seed."""
    written, status = problem.written, optimised.status
    scene, lines = written.scene, written.outside(optimised.world_lines)
    with clock.stage("certify"):
        certificate = certify(scene, written.free_space, lines)
    if not certificate.holds:
        lines, certificate, status = initial.world_lines, initial.certificate, Status.BROKEN
        optimised = replace(optimised, costs=optimised.seed_costs, scales=optimised.seed_scales)
    found = SeedReport.of(initial.seed, initial.world_lines, initial.certificate, scene)
    made = OptimisationReport.of(scene, optimised)
    figures = metrics(ending_as(scene, lines), lines)
    content = Report(
        scene, status, certificate, figures, found, made, notes=notes_of(problem.written.free_space)
    )
    run = RunRecord.of(clock, OptimisationTimes.of(optimised, clock.seconds["optimise"]))
    return Plan(initial.world_lines, lines, content, run)
