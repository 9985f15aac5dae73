"""The commands that look at what is planned: check, diff and explain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stplan.cli.command import command, group
from stplan.cli.console import Console
from stplan.cli.options import Overrides, RunOrScene, Trajectories
from stplan.cli.scenes import read_scene
from stplan.cli.signals import answered_by
from stplan.errors import UsageError
from stplan.stopping import StopRequest

if TYPE_CHECKING:
    from stplan.analysis.precedence import Endurance
    from stplan.problem.world_lines import WorldLines
    from stplan.scene.model import Scene

app = group()


class Format(StrEnum):
    """How a difference is written; `--json` is short for JSON."""

    TEXT = "text"
    JSON = "json"
    MARKDOWN = "markdown"


@command(app)
def check(
    console: Console,
    run_or_scene: RunOrScene,
    trajectories: Trajectories = None,
    *,
    overrides: Overrides = None,
    radius: Annotated[
        float | None, typer.Option(help="Against a map: of everybody, m.  [default: 0.3]")
    ] = None,
    fps: Annotated[
        float | None, typer.Option(help="Frames a second, where trajectories do not say.")
    ] = None,
    delay: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Also whether any one agent may stop for so long, if all keep the order of passing.  "
            "[default: what the scene asks for]",
        ),
    ] = None,
    order: Annotated[
        Path | None,
        typer.Option(
            "--precedence", metavar="FILE", help="Write who passes which spot before whom (JSON)."
        ),
    ] = None,
) -> int:
    """Certify trajectories against a scene, or against a map.

    In continuous time, and whoever wrote them: a .csv, a .npz or the folder of a run; text or SQLite of
    JuPedSim and PedPy, tables with other columns, MCAP, GeoJSON. Against a map of any format that is read
    (docs/formats.md), everybody is taken to be there from the first place to the last.
    Exit status 0 when the certificate holds, 1 when it is broken, or a delay is not survived.

    \b
    Examples:
      stplan check outputs/bottleneck
      stplan check scenes/bottleneck/bottleneck.yaml outputs/bottleneck/seed.csv
      stplan check hall.wkt walkers.txt --radius 0.2
      stplan check outputs/bottleneck --delay 2.0 --precedence order.json
    """
    for name, value in (("--radius", radius), ("--fps", fps), ("--delay", delay)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise UsageError(f"{name} is {value}; expected a number above 0")
    if trajectories is not None and _is_map(run_or_scene):
        from stplan.imports.tracks import scene_of_tracks

        judged = scene_of_tracks(run_or_scene, trajectories, radius or 0.3, fps)
        return _certified(console, *judged, changed=False, delay=delay, order=order)
    if radius is not None:
        raise UsageError("--radius is for maps; in a scene every agent has its own")
    scene, lines, changed = _scene_and_lines(
        "check", run_or_scene, trajectories, overrides or [], fps
    )
    if lines is None:
        raise UsageError(
            f"{run_or_scene} is not the folder of a run, so name the trajectories too: "
            f"stplan check {run_or_scene} TRAJECTORIES"
        )
    return _certified(console, scene, lines, changed=changed, delay=delay, order=order)


def _is_map(path: Path) -> bool:
    """Whether a file is a map rather than a scene; YAML may be both."""
    if not path.is_file():
        return False
    from stplan.maps.formats.registry import SUFFIXES
    from stplan.maps.mesh.base import SUFFIXES as MESHES

    suffix = path.suffix.lower()
    if suffix in (".yaml", ".yml"):
        with path.open("rb") as file:
            return b"stplan:" not in file.read(1_000_000)
    return suffix in (*SUFFIXES, *MESHES)


def _certified(
    console: Console,
    scene: Scene,
    lines: WorldLines,
    *,
    changed: bool,
    delay: float | None,
    order: Path | None,
) -> int:
    """Say whether a certificate holds, and what a delay does; the exit status."""
    from stplan.replanning import execution

    certificate = execution.check(scene, lines, progress=console.progress)
    if changed:
        console.progress(f"note: {scene.source} is not as it was when this run was planned")
    eased = [f"  {one}" for one in certificate.eased]
    console.result(f"{scene.name}: {certificate.summary}", *certificate.violations, *eased)
    content = {"scene_changed": changed, **certificate.as_dict()}
    status = 0 if certificate.holds else 1
    delay = delay or scene.robust.delay or None
    if certificate.holds and (delay is not None or order is not None):
        from stplan.analysis.precedence import endurance, longest_delay, precedence
        from stplan.files.atomic import write_set
        from stplan.files.json_file import json_bytes
        from stplan.problem.continuation import curves_of
        from stplan.problem.worlds import whole_scene

        whole = whole_scene(scene, curves_of(lines)) if scene.changes else scene
        found = precedence(whole, lines)
        if order is not None:
            write_set(order.parent, {order.name: json_bytes(found.as_dict())})
        if delay is not None:
            tried = endurance(found, delay)
            console.result(*_sentences(tried, longest_delay(found)))
            content["delay"] = tried.as_dict()
            status = 0 if tried.survives else 1
    console.result_json({"exit_status": status, **content})
    return status


def _sentences(tried: Endurance, longest: float) -> list[str]:
    """What a delay does, a sentence a line."""
    if not tried.survives:
        return [
            f"  a stop of {tried.delay:g} s is not survived, one of {longest:.4g} s is",
            *(f"  {one}" for one in tried.broken),
        ]
    head = f"  any one agent may stop for {tried.delay:g} s if all keep the order of passing"
    if not tried.late:
        return [f"{head}; nobody else is late"]
    who, by, whose = tried.late[0]
    return [f"{head}; {len(tried.late)} are late then, {who} most: {by:.3g} s where {whose} stops"]


@command(app)
def diff(
    console: Console,
    a: Annotated[
        Path,
        typer.Argument(metavar="A", help="A .csv, a .npz, a run's folder or a folder of runs."),
    ],
    b: Annotated[Path, typer.Argument(metavar="B", help="What to compare with A.")],
    *,
    atol: Annotated[float, typer.Option(help="Absolute tolerance, in m and in s.")] = 1e-9,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 0.0,
    output_format: Annotated[
        Format | None,
        typer.Option("--format", help="How to say it.  [default: text]", show_default=False),
    ] = None,
) -> int:
    """Compare two runs, or two folders of runs; for CI.

    Says which agent differs most, by how much, at which knot and when; which agents, and of two
    folders which runs, are only in one of them; and, where both have a report.json, whether the
    certificate changed. A is what is expected. Two knots agree when they are at most
    ATOL + RTOL * size apart, size being their distance to the origin (or their time).
    Exit status 0 when all is equal within the tolerances, 1 when something differs.

    \b
    Examples:
      stplan diff outputs/bottleneck expected/trajectories.csv --atol 1e-6
      stplan diff golden outputs --atol 1e-6 --format markdown >> "$GITHUB_STEP_SUMMARY"
    """
    console.as_json |= output_format == Format.JSON
    for name, value in (("--atol", atol), ("--rtol", rtol)):
        if not (math.isfinite(value) and value >= 0):
            raise UsageError(f"{name} is {value}; expected a finite number, at least 0")
    from stplan.files.compare_markdown import markdown_lines
    from stplan.files.compare_runs import RunDifference, compare_runs

    difference = compare_runs(a, b, atol, rtol)
    status = 0 if difference.equal else 1
    markdown = output_format == Format.MARKDOWN
    console.result(*(markdown_lines(difference) if markdown else difference.lines()))
    if console.verbose and not markdown:
        runs = (difference,) if isinstance(difference, RunDifference) else difference.runs
        for run in runs:
            if run.equal:
                prefix = f"{run.run}: " if run.run else ""
                console.result(*(prefix + agent.sentence() for agent in run.trajectories.agents))
    console.result_json({"exit_status": status, **difference.as_dict()})
    return status


@command(app)
def explain(
    console: Console,
    run_or_scene: RunOrScene,
    trajectories: Trajectories = None,
    *,
    everything: Annotated[
        bool, typer.Option("--all", help="Everything, not only the most important.")
    ] = False,
    time_limit: Annotated[
        float,
        typer.Option(help="Of a scene: longest search for initial curves, s; 0 leaves it out."),
    ] = 10.0,
    overrides: Overrides = None,
) -> int:
    """Say in words what is tight, who waits for whom, and why.

    Of a run, or of any trajectories against a scene: the pairs and walls that leave least room, who
    waits for whom, who is late, and who goes how much further than alone. Of a scene by itself:
    which places are narrow for which radii, who would meet whom, and whether initial curves are
    found; if not, whom that concerns, where and when.
    Exit status 0; 1 where the certificate is broken, 3 where no initial curves were found.

    \b
    Examples:
      stplan explain outputs/bottleneck
      stplan explain scenes/tight/cabin.yaml --all
      stplan explain scenes/bottleneck/bottleneck.yaml outputs/bottleneck/seed.csv --json
    """
    if not (math.isfinite(time_limit) and time_limit >= 0):
        raise UsageError(f"--time-limit is {time_limit}; expected a finite number, at least 0")
    scene, lines, changed = _scene_and_lines("explain", run_or_scene, trajectories, overrides or [])
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
        explanation, certificate = explain_run(scene, lines, report, progress=console.progress)
        status = 0 if certificate.holds else 1
    console.result(*explanation.lines(everything=everything))
    console.result_json({"exit_status": status, **explanation.as_dict()})
    return status


def _scene_and_lines(
    command: str,
    run_or_scene: Path,
    trajectories: Path | None,
    overrides: Sequence[str],
    fps: float | None = None,
) -> tuple[Scene, WorldLines | None, bool]:
    """A scene, the trajectories named with it or those of its run, and whether it changed since."""
    from stplan.files.foreign import renamed
    from stplan.files.run_folder import recorded_scene
    from stplan.files.trajectories import read_trajectories

    if not run_or_scene.is_dir():
        scene = read_scene(run_or_scene, overrides)
        if trajectories is None:
            return scene, None, False
        return scene, renamed(read_trajectories(trajectories, fps), scene), False
    recorded = recorded_scene(run_or_scene, command)
    scene = read_scene(recorded.source, [*recorded.overrides, *overrides])
    changed = recorded.content_hash not in (None, scene.content_hash)
    lines = read_trajectories(trajectories or run_or_scene, fps)
    return scene, renamed(lines, scene) if trajectories else lines, changed
