"""What the commands do, given a console: each returns its exit status.

Imports that take time wait inside the functions, so that help and usage errors come at once.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stplan.cli.console import Console, failure, plan_lines, worst, write
from stplan.cli.signals import answered_by
from stplan.errors import SceneError, UsageError
from stplan.files.atomic import uninterrupted
from stplan.stopping import StopRequest

if TYPE_CHECKING:
    from stplan.batch.campaign import Settings
    from stplan.batch.runs import Run
    from stplan.planner import Plan
    from stplan.problem.world_lines import WorldLines
    from stplan.scene.model import Scene


def _load(path: Path, overrides: Sequence[str]) -> Scene:
    if path.is_dir():
        raise UsageError(f"{path} is a folder; expected a scene file")
    if not path.exists():
        raise UsageError(f"cannot read {path}: no such file")
    from stplan.scene import load_scene

    return load_scene(path, overrides=tuple(overrides))


def plan_scenes(
    console: Console,
    paths: Sequence[Path],
    output: Path,
    overrides: Sequence[str],
    *,
    seed_only: bool,
) -> int:
    """Plan every scene that can be read; all that cannot are named first."""
    records: list[dict[str, Any]] = [
        {"scene": str(path), "exit_status": 0, "status": "not planned"} for path in paths
    ]
    scenes: dict[str, tuple[Scene, dict[str, Any]]] = {}
    for path, record in zip(paths, records, strict=True):
        try:
            scene = _load(path, overrides)
            if scene.name in scenes:
                other = scenes[scene.name][1]["scene"]
                raise UsageError(
                    f"{path} and {other} are both named {scene.name}, so one would overwrite "
                    "the other; rename one, or solve them apart"
                )
            scenes[scene.name] = scene, record
        except Exception as error:
            _note_failure(console, record, error)
    for scene, record in scenes.values():
        prefix = f"{scene.name}: " if len(paths) > 1 else ""
        try:
            _plan_one(console, scene, output, seed_only=seed_only, prefix=prefix, record=record)
        except (Exception, KeyboardInterrupt) as error:
            if isinstance(error, KeyboardInterrupt) and "files" in record:
                record["exit_status"] = 130
                console.error(f"{prefix}interrupted when its files were written already")
            else:
                _note_failure(
                    console, record, error, "" if isinstance(error, SceneError) else prefix
                )
        if record["exit_status"] == 130:
            break
    status = worst([record["exit_status"] for record in records])
    console.result_json({"exit_status": status, "scenes": records})
    return status


def _plan_one(
    console: Console,
    scene: Scene,
    output: Path,
    *,
    seed_only: bool,
    prefix: str,
    record: dict[str, Any],
) -> None:
    from stplan.planner import plan, seed

    def progress(line: str) -> None:
        console.progress(prefix + line)

    stop = StopRequest()
    with answered_by(stop.make):
        if seed_only:
            planned = seed(scene, progress=progress, stop=stop)
        else:
            with console.live_line(prefix) as live:
                planned = plan(scene, progress=progress, live=live, stop=stop)
    with uninterrupted():
        files = _write(planned, output / scene.name, seed_only)
        record |= {
            "name": scene.name,
            "exit_status": planned.exit_status,
            "status": planned.status,
            "advice": planned.advice,
            "folder": str(output / scene.name),
            "files": [str(path) for path in files],
            "report": planned.report,
            "run": planned.run,
        }
    if stop.made and planned.status != "interrupted":
        raise KeyboardInterrupt  # Too late to change anything of this scene, but not of the next.
    if planned.advice and not (console.quiet and planned.exit_status == 0):
        console.error(prefix + planned.advice)
    console.result(*plan_lines(planned, files, console.verbose))


def _write(planned: Plan, folder: Path, seed_only: bool) -> list[Path]:
    if not seed_only:
        from stplan.planner import write_plan

        return write_plan(planned, folder)
    # Without a report: one of an earlier `solve` in this folder still describes its trajectories.
    from stplan.files.trajectories import write_files

    return write_files(folder, planned.scene, {"seed": planned.seed})


def _note_failure(
    console: Console, record: dict[str, Any], error: BaseException, prefix: str = ""
) -> None:
    status, messages = failure(error)
    console.error(*(prefix + message for message in messages))
    record |= {"exit_status": status, "status": "error", "messages": messages}


def _scene_and_lines(
    command: str, run_or_scene: Path, trajectories: Path | None, overrides: Sequence[str]
) -> tuple[Scene, WorldLines | None, bool]:
    """A scene, the trajectories named with it or those of its run, and whether it changed since."""
    from stplan.files.run_folder import recorded_scene
    from stplan.files.trajectories import read_trajectories

    if not run_or_scene.is_dir():
        scene = _load(run_or_scene, overrides)
        return scene, None if trajectories is None else read_trajectories(trajectories), False
    recorded = recorded_scene(run_or_scene, command)
    scene = _load(recorded.source, [*recorded.overrides, *overrides])
    changed = recorded.content_hash not in (None, scene.content_hash)
    return scene, read_trajectories(trajectories or run_or_scene), changed


def check_trajectories(
    console: Console, run_or_scene: Path, trajectories: Path | None, overrides: Sequence[str]
) -> int:
    """Certify trajectories against the scene of a run, or against any scene."""
    scene, lines, changed = _scene_and_lines("check", run_or_scene, trajectories, overrides)
    if lines is None:
        raise UsageError(
            f"{run_or_scene} is not the folder of a run, so name the trajectories too: "
            f"stplan check {run_or_scene} TRAJECTORIES"
        )
    from stplan.planner import check as certify

    certificate = certify(scene, lines)
    if changed:
        console.progress(f"note: {scene.source} is not as it was when this run was planned")
    console.result(f"{scene.name}: {certificate.summary}", *certificate.violations)
    status = 0 if certificate.holds else 1
    console.result_json({"exit_status": status, "scene_changed": changed, **certificate.as_dict()})
    return status


def explain(
    console: Console,
    run_or_scene: Path,
    trajectories: Path | None,
    overrides: Sequence[str],
    time_limit: float,
    *,
    everything: bool,
) -> int:
    """Say in words what a run, any trajectories, or a scene by itself look like."""
    if not (math.isfinite(time_limit) and time_limit >= 0):
        raise UsageError(f"--time-limit is {time_limit}; expected a finite number, at least 0")
    scene, lines, changed = _scene_and_lines("explain", run_or_scene, trajectories, overrides)
    from stplan.explain.run import explain_run
    from stplan.explain.scene import explain_scene
    from stplan.files.recorded import REPORT, read_report

    if changed:
        console.progress(f"note: {scene.source} is not as it was when this run was planned")
    if lines is None:
        stop = StopRequest()
        with answered_by(stop.make):
            explanation, plannable = explain_scene(
                scene, time_limit=time_limit, progress=console.progress, stop=stop
            )
        status = 0 if plannable else 3
    else:
        report = None if trajectories else read_report(run_or_scene / REPORT)
        explanation, certificate = explain_run(scene, lines, report)
        status = 0 if certificate.holds else 1
    console.result(*explanation.lines(everything=everything))
    console.result_json({"exit_status": status, **explanation.as_dict()})
    return status


def compare(
    console: Console, a: Path, b: Path, atol: float, rtol: float, *, markdown: bool = False
) -> int:
    """Say where two runs, or two folders of runs, differ."""
    for name, value in (("--atol", atol), ("--rtol", rtol)):
        if not (math.isfinite(value) and value >= 0):
            raise UsageError(f"{name} is {value}; expected a finite number, at least 0")
    from stplan.files.compare_markdown import markdown_lines
    from stplan.files.compare_runs import RunDifference, compare_runs

    difference = compare_runs(a, b, atol, rtol)
    status = 0 if difference.equal else 1
    console.result(*(markdown_lines(difference) if markdown else difference.lines()))
    if console.verbose and not markdown:
        runs = (difference,) if isinstance(difference, RunDifference) else difference.runs
        for run in runs:
            if run.equal:
                prefix = f"{run.run}: " if run.run else ""
                console.result(*(prefix + agent.sentence() for agent in run.trajectories.agents))
    console.result_json({"exit_status": status, **difference.as_dict()})
    return status


def validate_scenes(console: Console, paths: Sequence[Path], overrides: Sequence[str]) -> int:
    """Check every scene and its map; faults of all are said."""
    records = []
    for path in paths:
        record: dict[str, Any] = {"scene": str(path), "exit_status": 0}
        records.append(record)
        try:
            scene = _load(path, overrides)
            from stplan.world import fitted_free_space

            fitted_free_space(scene)
        except Exception as error:
            _note_failure(console, record, error)
        else:
            record |= {"name": scene.name, "status": "valid"}
            console.result(f"{path}: valid, {scene.name} with {len(scene.agents)} agents")
    status = worst([record["exit_status"] for record in records])
    console.result_json({"exit_status": status, "scenes": records})
    return status


def print_schema(console: Console) -> int:
    """The JSON Schema of scene files."""
    from stplan.scene import scene_schema

    console.result_json(scene_schema())
    return 0


def run_batch(
    console: Console,
    sources: Sequence[str],
    *,
    output: Path,
    overrides: Sequence[str],
    sweeps: Sequence[str],
    filters: Sequence[str],
    jobs: int | None,
    timeout: float | None,
    retries: int,
    fail_fast: bool,
    force: bool,
    dask: str | None,
    dry_run: bool,
    output_format: str,
) -> int:
    """Plan many scenes in parallel, but for those that are done."""
    if timeout is not None and not (math.isfinite(timeout) and timeout > 0):
        raise UsageError(f"--timeout is {timeout}; expected a number of seconds above 0")
    from stplan.batch.campaign import Settings, run_batch
    from stplan.batch.formats import github, junit
    from stplan.batch.runs import list_runs
    from stplan.batch.summary import SUMMARIES, summary
    from stplan.batch.watchers import LineWatcher, live_table

    runs = list_runs(
        sources, output=output, overrides=overrides, sweeps=sweeps, filters=filters
    )  # fmt: skip
    settings = Settings(
        output,
        jobs or usable_cores(),
        timeout,
        retries,
        fail_fast=fail_fast,
        force=force,
        dask=dask,
    )
    if dry_run:
        return _preview(console, runs, settings)
    if sys.stderr.isatty() and not (console.quiet or console.verbose):
        with live_table() as table:
            batch = run_batch(runs, settings, table)
        console.error(*(line for result in batch.results for line in result.complaints))
    else:
        batch = run_batch(
            runs, settings, LineWatcher(console.progress, console.error, console.verbose)
        )
    status = worst(batch.exit_statuses)
    console.result_json({"exit_status": status, **summary(batch)})
    if output_format == "junit":
        write(sys.stdout, junit(batch))
    elif output_format == "github":
        write(sys.stdout, github(batch))
    else:
        console.result(batch.sentence, f"  {output}{os.sep}: {' '.join(SUMMARIES)}")
    return status


def usable_cores() -> int:
    """Cores that this process may use; a scheduler may have given it fewer than there are."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _preview(console: Console, runs: Sequence[Run], settings: Settings) -> int:
    """Say what a batch would do."""
    from stplan.batch.folder import found

    records: list[dict[str, Any]] = []
    for run in runs:
        what, why = "refused", "; ".join(run.refusal)
        if not run.refusal:
            why = "--force" if settings.force else found(run, settings.output / run.name).missing
            what = "plan" if why else "done"
        records.append(
            {
                "run": run.name, "scene": str(run.source), "overrides": list(run.overrides),
                "hash": run.content_hash or None, "action": what, "reason": why or None,
            }
        )  # fmt: skip
        console.result(f"{what:7}  {run.name}" + (f": {why}" if why else ""))
    status = 2 if any(run.refusal for run in runs) else 0
    console.result_json({"exit_status": status, "runs": records})
    return status
