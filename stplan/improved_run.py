"""A finished run's folder, improved: read back, and written anew as one set of files.

What only its planning could tell (the seed's own figures) stays as it was reported; everything about the
trajectories is made anew. Runs that are damaged, that were planned from another state of their scene, or
whose trajectories do not hold their certificate, are refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.metrics import metrics
from stplan.callbacks import Progress, Stop
from stplan.certify.certificate import Certificate, certify
from stplan.clock import Clock
from stplan.errors import UsageError
from stplan.files.details import DETAILS, Arrays, report_files
from stplan.files.json_file import json_bytes, read_json
from stplan.files.manifest import KEY, manifest, why_incomplete
from stplan.files.npz_file import read_arrays, read_npz
from stplan.files.recorded import REPORT, RUN_RECORD
from stplan.files.trajectories import curve_files, read_trajectories
from stplan.improvement.budget import ImprovementBudget, require_energy
from stplan.improvement.search import Improvement
from stplan.improvement.search import improve as improve_lines
from stplan.optimize.continuation import LiveLine
from stplan.planner import prepare
from stplan.problem.ends import fixed_at
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.report import OptimisationReport, versions
from stplan.scene.model import Scene
from stplan.scene.moving_goals import is_play
from stplan.status import Status

SEED, TRAJECTORIES = "seed.npz", "trajectories.npz"


@dataclass(frozen=True)
class FinishedRun:
    """What a run's folder holds.

    Attributes:
        problem: of its scene.
        report, record: the content of report.json and run.json.
        details: arrays that the report names.
    """

    problem: PlanningProblem
    seed: WorldLines
    trajectories: WorldLines
    report: dict[str, Any]
    record: dict[str, Any]
    details: Arrays = field(default_factory=dict)

    @property
    def scene(self) -> Scene:
        """What it is a run of."""
        return self.problem.written.scene


@dataclass(frozen=True)
class ImprovedRun:
    """A run with cheaper trajectories, or with the same ones.

    Attributes:
        files: content of all files of its folder, by name.
    """

    status: Status
    certificate: Certificate
    improvement: Improvement
    files: dict[str, bytes]


def read_run(folder: Path, scene: Scene) -> FinishedRun:
    """The run in `folder`, which is one of `scene`.

    Raises:
        UsageError: it is damaged, of another state of the scene, or does not hold its certificate; or the
            scene minimises arrivals.
        SceneError: the scene does not fit its map, or not into memory.
    """
    require_energy(scene)
    why = why_incomplete(folder)
    if why:
        raise UsageError(f"{folder} is not the whole of one run: {why}")
    report = read_json(folder / REPORT)
    if report.get("scene", {}).get("hash") != scene.content_hash:
        raise UsageError(f"{scene.source} is not as it was when {folder} was planned; plan it anew")
    if is_play(scene):
        raise UsageError(f"{folder}: what was played is past improvement")
    if scene.changes:
        raise UsageError(f"{folder}: what was executed while its world changed is past improvement")
    file = read_npz(folder / TRAJECTORIES)
    lines = file.world_lines
    if scene.metric == "auto" and file.time_scale is not None:
        # The trajectories' rods are clear in the metric that they were planned with.
        turning = scene.turning_scale
        scene = replace(scene, time_scale=file.time_scale, metric="chosen", turning=turning)
    problem = prepare(fixed_at(scene, lines))
    certificate = certify(scene, problem.written.free_space, lines)
    if not certificate.holds:
        raise UsageError(f"{folder}: {certificate.summary}; only certified runs are improved")
    seed = read_trajectories(folder / SEED)
    details = folder / DETAILS
    known = read_arrays(details) if details.exists() else {}
    return FinishedRun(problem, seed, lines, report, read_json(folder / RUN_RECORD), known)


def improve_run(
    run: FinishedRun,
    budget: ImprovementBudget,
    *,
    progress: Progress,
    stop: Stop,
    live: LiveLine | None = None,
) -> ImprovedRun:
    """`run` with the cheapest trajectories that the moves of `budget` lead to."""
    clock = Clock()
    scene = run.scene
    with clock.stage("improve"):
        found = improve_lines(
            run.problem,
            run.trajectories,
            budget,
            rng_seed=scene.seeding.rng_seed,
            progress=progress,
            live=live,
            stop=stop,
        )
    status = Status(run.report["status"])
    report = run.report | {"improvement": found.record.as_dict(), "versions": versions()}
    report |= {"bound": cost_bound(run.problem, found.world_lines).as_dict()}
    if found.optimisation is not None:
        status = found.optimisation.status
        report |= {
            "certificate": found.certificate.as_dict(),
            "metrics": metrics(scene, found.world_lines).as_dict(),
        }
        report |= OptimisationReport.of(scene, found.optimisation).as_dict()
    status = Status.INTERRUPTED if found.interrupted else status
    report |= {"status": status, "advice": status.advice}
    curves = {"seed": run.seed, "trajectories": found.world_lines}
    contents = curve_files(scene, curves)
    contents |= report_files(report, len(scene.agents), run.details)
    seconds = dict(run.record.get("seconds", {}))
    for name in ("improve", "total"):
        seconds[name] = seconds.get(name, 0.0) + clock.seconds["improve"]
    record = run.record | {"seconds": seconds, KEY: manifest(contents)}
    return ImprovedRun(
        status, found.certificate, found, contents | {RUN_RECORD: json_bytes(record)}
    )
