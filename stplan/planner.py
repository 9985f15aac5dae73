"""The whole story: scene -> free space -> seed -> optimise -> certify -> write."""

from __future__ import annotations

import platform
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from types import FrameType
from typing import Any

from stplan.analysis.metrics import metrics
from stplan.certify.certificate import Certificate, certify
from stplan.compiled import compiled_before
from stplan.errors import SeedingError
from stplan.files.atomic import write_set
from stplan.files.json_file import json_bytes
from stplan.files.manifest import KEY, RUN_RECORD, seal
from stplan.files.run_folder import REPORT
from stplan.files.trajectories import curve_files
from stplan.geometry.segments import squared_distance
from stplan.memory import LEAST_KNOTS, MIB, peak, require_memory
from stplan.multistart import best_seed
from stplan.nlp.ipopt.adapter import versions as ipopt_versions
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.optimize.continuation import LiveLine, Optimisation, optimise
from stplan.optimize.restoration import restore
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.seeding.portfolio import Seed
from stplan.status import Status
from stplan.world import build_free_space, fitted_free_space

Progress = Callable[[str], None]

# So many broken promises of initial curves are told.
MOST_VIOLATIONS = 5


@dataclass(frozen=True)
class Plan:
    """A planned (or only seeded) scene.

    Attributes:
        seed: the initial curves.
        trajectories: the optimised curves, None where only a seed was asked for.
        certificate: of the trajectories, or of the seed.
        report: what report.json holds, repeatable.
        run: what run.json holds, different every time.
        status: how planning ended.
    """

    scene: Scene
    seed: WorldLines
    trajectories: WorldLines | None
    certificate: Certificate
    report: dict[str, Any]
    run: dict[str, Any]
    status: Status

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
    stop: Callable[[], bool] | None = None,
) -> Plan:
    """Plan `scene`: find a seed, optimise it, certify the result.

    While optimising, `live` is given a maker of a progress line after every iteration of Ipopt.
    Interrupted (SIGINT, SIGTERM) while optimising, it returns the best feasible curves so far; so it
    does when `stop`, asked after every iteration, returns True.

    Raises:
        SceneError: the scene does not fit its map, or not into memory.
        SeedingError: no collision-free initial curves were found.
        SolverError: Ipopt lacks the linear solver or an option asked for.
        KeyboardInterrupt: interrupted before there were any.
    """
    say = progress or (lambda line: None)
    clock = _Clock()
    linear_solver = chosen_linear_solver(scene)
    problem, seed, seed_certificate = _seeded(scene, say, clock)
    with _interruptible() as interrupted:
        outcome = optimise(
            problem, seed.world_lines, progress=say, live=live,
            stop=lambda: interrupted() or (stop is not None and stop()),
        )  # fmt: skip
    clock.lap("optimise")
    certificate = certify(scene, problem.free_space, outcome.world_lines)
    clock.lap("certify")
    lines, status = outcome.world_lines, outcome.status
    if not certificate.holds:
        lines, certificate, status = seed.world_lines, seed_certificate, Status.BROKEN
    report = _report(scene, seed, seed_certificate, certificate, lines, status)
    report["linear_solver"] = linear_solver
    report["costs"] = outcome.costs
    report["outer_iterations"] = outcome.record
    run = _run(clock) | {"optimisation": _optimisation_times(outcome, clock)}
    return Plan(scene, seed.world_lines, lines, certificate, report, run, status)


def seed(scene: Scene, *, progress: Progress | None = None) -> Plan:
    """Only the initial curves of `scene`, certified. Raises like `plan`."""
    clock = _Clock()
    _, found, certificate = _seeded(scene, progress or (lambda line: None), clock)
    report = _report(scene, found, certificate, certificate, found.world_lines, Status.SEEDED)
    return Plan(scene, found.world_lines, None, certificate, report, _run(clock), Status.SEEDED)


def check(scene: Scene, lines: WorldLines) -> Certificate:
    """The certificate of any trajectories against `scene`. Raises SceneError for a bad map."""
    return certify(scene, build_free_space(scene), lines)


def write_plan(result: Plan, folder: Path) -> list[Path]:
    """Write a plan's files into `folder` (made if needed) and return their paths."""
    return write_set(folder, plan_files(result))


def plan_files(result: Plan) -> dict[str, bytes]:
    """What `write_plan` writes, by file name: the record with the seal of all others comes last."""
    curves = {"seed": result.seed}
    if result.trajectories is not None:
        curves["trajectories"] = result.trajectories
    contents = curve_files(result.scene, curves) | {REPORT: json_bytes(result.report)}
    return contents | {RUN_RECORD: json_bytes(result.run | {KEY: seal(contents)})}


def _seeded(
    scene: Scene, say: Progress, clock: _Clock
) -> tuple[PlanningProblem, Seed, Certificate]:
    count = len(scene.agents)
    require_memory(scene.name, count, count * (scene.solver.knots or LEAST_KNOTS))
    free_space = fitted_free_space(scene)
    clock.lap("world")
    if not compiled_before(squared_distance):
        say("compiling, once after installation: this takes about a quarter of a minute")
    problem = PlanningProblem.from_scene(scene, free_space)
    found = best_seed(problem, progress=say)
    with _interruptible() as interrupted:
        lines = restore(
            problem, found.world_lines, found.rendezvous, progress=say, stop=interrupted
        )
        if interrupted():
            raise KeyboardInterrupt
    found = replace(found, world_lines=lines)
    clock.lap("seed")
    certificate = certify(scene, free_space, lines)
    clock.lap("certify")
    if not certificate.holds:
        raise SeedingError(_broken_promises(certificate))
    return problem, found, certificate


def _broken_promises(certificate: Certificate) -> str:
    """What the best initial curves miss of all that the scene asks."""
    shown = list(certificate.violations[:MOST_VIOLATIONS])
    more = len(certificate.violations) - len(shown)
    shown += [f"and {more} more"] if more else []
    return "no initial curves were found that hold their certificate; of the best ones:\n  " + (
        "\n  ".join(shown)
    )


def _report(
    scene: Scene,
    seed: Seed,
    seed_certificate: Certificate,
    certificate: Certificate,
    lines: WorldLines,
    status: Status,
) -> dict[str, Any]:
    tightest = seed_certificate.smallest
    return {
        "format": 1,
        "status": status,
        "advice": status.advice,
        "scene": {
            "name": scene.name,
            "source": None if scene.source is None else str(scene.source),
            "hash": scene.content_hash,
        },
        "versions": versions(),
        "certificate": certificate.as_dict(),
        "metrics": metrics(scene, lines),
        "seed": {
            "found_by": seed.found_by,
            "record": seed.record.as_dict(),
            "smallest_clearance": None if tightest is None else tightest.clearance,
            "metrics": metrics(scene, seed.world_lines),
        },
    }


@cache
def versions() -> dict[str, str]:
    """Versions of this program and of what its results depend on."""
    names = ("stplan", "numpy", "scipy", "numba", "shapely", "trimesh")
    return {name: metadata.version(name) for name in names} | ipopt_versions()


class _Clock:
    """Seconds a stage of the pipeline took, added up by name."""

    def __init__(self) -> None:
        self.started = datetime.now(UTC)
        self._begin = self._last = time.perf_counter()
        self.laps: dict[str, float] = {}

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._last
        self._last = now

    @property
    def total(self) -> float:
        return self._last - self._begin


def _run(clock: _Clock) -> dict[str, Any]:
    return {
        "started": clock.started.isoformat(),
        "seconds": {**clock.laps, "total": clock.total},
        "host": platform.node(),
        "platform": platform.platform(),
        "python": platform.python_version(),
        "peak_memory_mib": round(peak() / MIB, 1),
    }


def _optimisation_times(outcome: Optimisation, clock: _Clock) -> dict[str, Any]:
    """How the optimiser's time splits into evaluation and the rest, nearly all linear algebra."""
    whole = clock.laps["optimise"]
    evaluation = outcome.watch.objective + outcome.watch.hessian
    return {
        "iterations": outcome.iterations,
        "seconds_per_iteration": whole / max(outcome.iterations, 1),
        "seconds": {
            "objective_and_gradient": outcome.watch.objective,
            "hessian": outcome.watch.hessian,
            "evaluation": evaluation,
            "linear_solve_and_rest": whole - evaluation,
        },
        "evaluations": outcome.watch.evaluations,
        "refused_steps": outcome.watch.refused,
        "hessian_nonzeros": outcome.nonzeros,
    }


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Within, the first SIGINT or SIGTERM asks politely; a second one interrupts at once."""
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return

    def ask(number: int, frame: FrameType | None) -> None:
        del number, frame
        if asked.is_set():
            raise KeyboardInterrupt
        asked.set()

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield asked.is_set
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
