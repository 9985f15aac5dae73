"""The whole story: prepare -> seed -> restore -> certify -> optimise -> certify -> write.

Every stage is a function of the prepared problem and of what the stage before it gave. `plan` and
`stplan batch` go through all of them; `seed`, `explain` and the benchmarks go through the same ones, as far
as they need.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from stplan.analysis.metrics import metrics
from stplan.certify.certificate import Certificate, certify
from stplan.clock import Clock
from stplan.compiled import compiled_before
from stplan.errors import BrokenSeedError, StoppedError
from stplan.files.atomic import write_set
from stplan.files.json_file import json_bytes
from stplan.files.manifest import KEY, manifest
from stplan.files.recorded import REPORT, RUN_RECORD
from stplan.files.trajectories import curve_files
from stplan.geometry.segments import closest_parameters
from stplan.multistart import best_seed
from stplan.nlp.ipopt.adapter import require_options
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.optimize.continuation import LiveLine, Optimisation, optimise
from stplan.optimize.restoration import restore
from stplan.problem import planning_problem
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.report import OptimisationReport, OptimisationTimes, Report, RunRecord, SeedReport
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Seed
from stplan.status import Status

Progress = Callable[[str], None]
Stop = Callable[[], bool]


@dataclass(frozen=True)
class InitialCurves:
    """A seed that keeps all that the scene asks: from here on there is something to keep.

    Attributes:
        seed: its world lines are the restored ones.
        certificate: of them; it holds.
    """

    seed: Seed
    certificate: Certificate


@dataclass(frozen=True)
class Plan:
    """A planned (or only seeded) scene.

    Attributes:
        seed: the initial curves.
        trajectories: the optimised curves, None where only a seed was asked for.
        certificate: of the trajectories, or of the seed.
        report: what report.json holds, repeatable.
        run: what run.json holds, different every time.
    """

    scene: Scene
    seed: WorldLines
    trajectories: WorldLines | None
    certificate: Certificate
    report: Report
    run: RunRecord

    @property
    def status(self) -> Status:
        """How planning ended."""
        return self.report.status

    @property
    def advice(self) -> str:
        """A sentence on what the status means, empty where all is well."""
        return self.status.advice

    @property
    def exit_status(self) -> int:
        """The command's."""
        return self.status.exit_status


def plan(
    scene: Scene,
    *,
    progress: Progress | None = None,
    live: LiveLine | None = None,
    stop: Stop | None = None,
) -> Plan:
    """Plan `scene`: find a seed, optimise it, certify the result.

    Args:
        progress: called with a line now and then.
        live: given a maker of a progress line after every iteration of Ipopt.
        stop: asked while there are curves to keep, after every iteration; True ends with the best
            feasible ones so far. `stplan.stopping` has one for handlers of signals.

    Raises:
        SceneError: the scene does not fit its map, or not into memory.
        SeedingError: no collision-free initial curves were found.
        SolverError: Ipopt lacks the linear solver or an option asked for.
        StoppedError: stopped before there were curves that keep all that the scene asks.
    """
    progress, stop = progress or _silent, stop or _never
    clock = Clock()
    with clock.stage("world"):
        problem = prepare(scene)
    initial = find_initial_curves(problem, progress=progress, stop=stop, clock=clock)
    stop()  # The answer is heeded below; who is asked knows that from here on a plan is certain.
    with clock.stage("optimise"):
        optimised = optimise(
            problem, initial.seed.world_lines, progress=progress, live=live, stop=stop
        )  # fmt: skip
    with clock.stage("certify"):
        certificate = certify(scene, problem.free_space, optimised.world_lines)
    return _planned(scene, initial, optimised, certificate, clock)


def seed(scene: Scene, *, progress: Progress | None = None, stop: Stop | None = None) -> Plan:
    """Only the initial curves of `scene`, certified. Raises like `plan`."""
    clock = Clock()
    with clock.stage("world"):
        problem = prepare(scene)
    initial = find_initial_curves(problem, progress=progress, stop=stop, clock=clock)
    found = SeedReport.of(initial.seed, initial.certificate, scene)
    content = Report(scene, Status.SEEDED, initial.certificate, found.metrics, found)
    lines = initial.seed.world_lines
    return Plan(scene, lines, None, initial.certificate, content, RunRecord.of(clock))


def check(scene: Scene, lines: WorldLines) -> Certificate:
    """The certificate of any trajectories against `scene`. Raises SceneError for a bad map."""
    if scene.map is None:
        return certify(scene, None, lines)
    from stplan.world import build_free_space

    return certify(scene, build_free_space(scene), lines)


def write_plan(result: Plan, folder: Path) -> list[Path]:
    """Write a plan's files into `folder` (made if needed) and return their paths."""
    return write_set(folder, plan_files(result))


def plan_files(result: Plan) -> dict[str, bytes]:
    """What `write_plan` writes, by file name: the record with the manifest of all others comes last."""
    curves = {"seed": result.seed}
    if result.trajectories is not None:
        curves["trajectories"] = result.trajectories
    contents = curve_files(result.scene, curves) | {REPORT: json_bytes(result.report.as_dict())}
    return contents | {RUN_RECORD: json_bytes(result.run.as_dict() | {KEY: manifest(contents)})}


def prepare(scene: Scene) -> PlanningProblem:
    """The problem of `scene`; whatever may be refused without any work is refused here.

    Raises:
        SceneError: the scene does not fit its map, or not into memory.
        SolverError: Ipopt lacks the linear solver or an option asked for.
    """
    chosen_linear_solver(scene)
    require_options(scene.solver.ipopt)
    return planning_problem.prepare(scene)


def find_initial_curves(
    problem: PlanningProblem,
    *,
    progress: Progress | None = None,
    stop: Stop | None = None,
    clock: Clock | None = None,
) -> InitialCurves:
    """The cheapest seed found, made to keep the limits and times of the scene, and certified.

    Raises:
        SeedingError: none was found; BrokenSeedError where none holds its certificate.
        StoppedError: `stop` said so before the limits were kept.
    """
    progress, stop, clock = progress or _silent, stop or _never, clock or Clock()
    scene, free_space = problem.scene, problem.free_space
    with clock.stage("seed"):
        if not compiled_before(closest_parameters):
            progress("compiling, once after installation: this takes about a quarter of a minute")
        found = best_seed(problem, progress=progress)
        lines = restore(problem, found.world_lines, found.rendezvous, progress=progress, stop=stop)
        if lines is not found.world_lines and stop():
            raise StoppedError
    with clock.stage("certify"):
        certificate = certify(scene, free_space, lines)
    if not certificate.holds:
        raise BrokenSeedError(certificate.violations)
    return InitialCurves(replace(found, world_lines=lines), certificate)


def _planned(
    scene: Scene,
    initial: InitialCurves,
    optimised: Optimisation,
    certificate: Certificate,
    clock: Clock,
) -> Plan:
    """The optimised curves where they hold their certificate, else the seed."""
    lines, status, costs = optimised.world_lines, optimised.status, optimised.costs
    if not certificate.holds:
        lines, certificate, status = initial.seed.world_lines, initial.certificate, Status.BROKEN
        costs = optimised.seed_costs
    found = SeedReport.of(initial.seed, initial.certificate, scene)
    made = OptimisationReport(chosen_linear_solver(scene), costs, optimised.outer_iterations)
    content = Report(scene, status, certificate, metrics(scene, lines), found, made)
    run = RunRecord.of(clock, OptimisationTimes.of(optimised, clock.seconds["optimise"]))
    return Plan(scene, initial.seed.world_lines, lines, certificate, content, run)


def _silent(line: str) -> None:
    del line


def _never() -> bool:
    return False
