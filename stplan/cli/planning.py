"""The commands that plan: solve and seed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stplan.cli.command import command, group
from stplan.cli.console import Console, note_failure, worst
from stplan.cli.cores import usable_cores
from stplan.cli.options import Budget, Cluster, Output, Overrides, ScenePaths, Workers
from stplan.cli.scenes import read_scene
from stplan.cli.signals import answered_by
from stplan.errors import SceneError, StoppedError, UsageError
from stplan.stopping import StopRequest

if TYPE_CHECKING:
    from distributed import Client

    from stplan.analysis.metrics import AgentMetrics
    from stplan.improvement.budget import ImprovementBudget
    from stplan.planner import Plan
    from stplan.scene.model import Scene

app = group()

Record = dict[str, Any]


@command(app)
def solve(
    console: Console,
    scenes: ScenePaths,
    *,
    output: Output = Path("outputs"),
    overrides: Overrides = None,
    improve: Budget = None,
    workers: Workers = None,
    dask: Cluster = None,
) -> int:
    """Plan scenes; write their trajectories and a report.

    For every scene initial curves are found that are clear of each other and of the walls, then all
    are made smooth and cheap at once, and the result is certified by code of its own. Interrupted
    (Ctrl-C, SIGTERM) it writes the best feasible trajectories so far. The same scene gives the same
    bytes, run.json excepted, whatever --workers and --dask.

    With --improve the plan is improved afterwards: other ways around each other are tried for a few
    agents at a time, and what is cheaper and certified is kept.

    Of several scenes each is planned; the exit status is the worst of them, in the order
    5, 130, 2, 3, 4, 0.

    \b
    Examples:
      stplan solve scenes/bottleneck/bottleneck.yaml
      stplan solve scene.yaml -o results --set solver.outer_iterations=8
      stplan solve scenes/*/*.yaml --quiet
      stplan solve scenes/tight/cabin.yaml --improve 30s
      stplan solve city.yaml --dask tcp://10.0.0.1:8786
    """
    from stplan.clusters import connected

    num_workers = workers or usable_cores()
    with nullcontext() if dask is None else connected(dask, num_workers) as cluster:
        return _plan_scenes(
            console, scenes, output, overrides or [],
            seed_only=False, improve=improve, num_workers=num_workers, cluster=cluster,
        )  # fmt: skip


@command(app)
def seed(
    console: Console,
    scenes: ScenePaths,
    *,
    output: Output = Path("outputs"),
    overrides: Overrides = None,
) -> int:
    """Find only the initial curves.

    Writes seed.csv and seed.npz: curves that are clear, but neither smooth nor cheap. Exit status 3
    where none are found; `stplan explain SCENE` then says more.

    \b
    Example:
      stplan seed scenes/bottleneck/bottleneck.yaml --set seeding.rng_seed=3
    """
    return _plan_scenes(console, scenes, output, overrides or [], seed_only=True)


def _plan_scenes(
    console: Console,
    paths: Sequence[Path],
    output: Path,
    overrides: Sequence[str],
    *,
    seed_only: bool,
    improve: str | None = None,
    num_workers: int = 1,
    cluster: Client | None = None,
) -> int:
    """Plan every scene that can be read; all that cannot are named first."""
    from stplan.improvement.budget import ImprovementBudget

    budget = None if improve is None else ImprovementBudget.parse(improve)
    records: list[Record] = [
        {"scene": str(path), "exit_status": 0, "status": "not planned"} for path in paths
    ]
    for scene, record in _readable(console, paths, overrides, records, improved=budget is not None):
        prefix = f"{scene.name}: " if len(paths) > 1 else ""
        try:
            _plan_one(
                console, scene, output, budget,
                seed_only=seed_only, prefix=prefix, record=record,
                num_workers=num_workers, cluster=cluster,
            )  # fmt: skip
        except (Exception, KeyboardInterrupt) as error:
            if isinstance(error, KeyboardInterrupt) and "files" in record:
                record["exit_status"] = StoppedError.exit_status
                console.error(f"{prefix}interrupted when its files were written already")
            else:
                note_failure(
                    console, record, error, "" if isinstance(error, SceneError) else prefix
                )
        if record["exit_status"] == StoppedError.exit_status:
            break
    status = worst([record["exit_status"] for record in records])
    console.result_json({"exit_status": status, "scenes": records})
    return status


def _readable(
    console: Console,
    paths: Sequence[Path],
    overrides: Sequence[str],
    records: Sequence[Record],
    *,
    improved: bool,
) -> list[tuple[Scene, Record]]:
    """The scenes to be planned, each with its record; what is wrong with the others is said and noted."""
    scenes: dict[str, tuple[Scene, Record]] = {}
    for path, record in zip(paths, records, strict=True):
        try:
            scene = read_scene(path, overrides)
            if improved:
                from stplan.improvement.budget import require_energy

                require_energy(scene)
            if scene.name in scenes:
                other = scenes[scene.name][1]["scene"]
                raise UsageError(
                    f"{path} and {other} are both named {scene.name}, so one would overwrite "
                    "the other; rename one, or solve them apart"
                )
            scenes[scene.name] = scene, record
        except Exception as error:
            note_failure(console, record, error)
    return list(scenes.values())


def _plan_one(
    console: Console,
    scene: Scene,
    output: Path,
    budget: ImprovementBudget | None,
    *,
    seed_only: bool,
    prefix: str,
    record: Record,
    num_workers: int,
    cluster: Client | None,
) -> None:
    """Plan a scene, write its files and fill its record."""
    from stplan import planner
    from stplan.replanning import execution
    from stplan.scene.moving_goals import is_play

    def progress(line: str) -> None:
        console.progress(prefix + line)

    if budget is not None and scene.changes:
        raise UsageError(f"{scene.name} has events: what is executed with them is past improvement")
    if budget is not None and is_play(scene):
        raise UsageError(
            f"{scene.name} has goals that move, perception or tasks: what is played is past improvement"
        )
    stop = StopRequest()
    with answered_by(stop.make):
        if seed_only:
            planned = execution.seed(scene, progress=progress, stop=stop)
        else:
            with console.live_line(prefix) as live:
                planned = execution.plan(
                    scene, progress=progress, live=live, stop=stop,
                    num_workers=num_workers, cluster=cluster,
                )  # fmt: skip
                if budget is not None:
                    planned = planner.improve(
                        planned, budget, progress=progress, live=live, stop=stop
                    )
        with stop.held():
            files = _write(planned, output / scene.name, seed_only)
            record |= {
                "name": scene.name,
                "exit_status": planned.exit_status,
                "status": planned.status,
                "advice": planned.advice,
                "folder": str(output / scene.name),
                "files": [str(path) for path in files],
                "report": planned.report.as_dict(),
                "run": planned.run.as_dict(),
            }
    if planned.advice and not (console.quiet and planned.exit_status == 0):
        console.error(prefix + planned.advice)
    console.result(*_plan_lines(planned, files, console.verbose))
    if stop.made and planned.exit_status != StoppedError.exit_status:
        raise KeyboardInterrupt  # Too late to change anything of this scene, but not of the next.


def _write(planned: Plan, folder: Path, seed_only: bool) -> list[Path]:
    if not seed_only:
        from stplan.planner import write_plan

        return write_plan(planned, folder)
    # Without a report: one of an earlier `solve` in this folder still describes its trajectories.
    from stplan.files.trajectories import write_files

    return write_files(folder, planned.scene, {"seed": planned.seed})


def _plan_lines(plan: Plan, files: list[Path], verbose: bool) -> list[str]:
    """A plan in a few lines."""
    metrics, eased = plan.report.metrics, plan.certificate.eased
    lines = [f"{plan.scene.name}: {plan.status}", f"  {plan.certificate.summary}"]
    lines += [f"  {one}" for one in eased]
    for played in (plan.report.chases, plan.report.throughput):
        if played is not None:
            return [*lines, *(f"  {one}" for one in played.sentences), *_files_line(files)]
    figures = []
    if metrics.kinetic_over_straight is not None:
        ratio = metrics.kinetic_over_straight
        figures.append(f"kinetic cost {ratio:.4f} times the straight lines'")
    figures.append(f"latest arrival {metrics.latest_arrival:.2f} s")
    lines.append("  " + ", ".join(figures))
    if plan.report.bound is not None:
        lines.append(f"  {plan.report.bound.sentence}")
    if plan.report.arrivals is not None:
        lines.append(f"  {plan.report.arrivals.sentence}")
    if verbose:
        lines += [_agent_line(agent) for agent in metrics.agents]
        spent = ", ".join(f"{name} {amount:.2f} s" for name, amount in plan.run.seconds.items())
        lines += [f"  {spent}"]
    if plan.report.robustness is not None:
        lines += [f"  {one}" for one in plan.report.robustness.sentences]
    if plan.report.improvement is not None:
        lines.append(f"  {plan.report.improvement.sentence}")
    return [*lines, *_files_line(files)]


def _files_line(files: list[Path]) -> list[str]:
    if not files:
        return []
    return [f"  {files[0].parent}{os.sep}: {' '.join(path.name for path in files)}"]


def _agent_line(agent: AgentMetrics) -> str:
    return (
        f"  {agent.agent}: arrives {agent.arrival_time:.2f} s, "
        f"path {agent.path_length:.2f} m, fastest {agent.greatest_speed:.2f} m/s"
    )
