"""A run's folder, gone on with: its past to the byte, and another future for what happens from some time on.

What happens is added to the events of the run's scene, as one more override, so that the new run is checked
and replanned like any other.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stplan.analysis.metrics import metrics
from stplan.callbacks import Progress, Stop
from stplan.certify.certificate import Certificate
from stplan.certify.history import rest_certificate
from stplan.errors import SceneError, UsageError
from stplan.files.json_file import read_json
from stplan.files.manifest import why_incomplete
from stplan.files.npz_file import read_npz
from stplan.files.recorded import REPORT, RUN_RECORD
from stplan.files.run_folder import recorded_scene
from stplan.files.trajectories import read_trajectories
from stplan.planned import Plan
from stplan.problem.continuation import curves_of
from stplan.problem.worlds import space_of, whole_scene
from stplan.replanning.execution import check, go_on
from stplan.report import Report, RunRecord, SeedReport
from stplan.scene import load_scene
from stplan.scene.model import Scene, WorldChange
from stplan.scene.moving_goals import is_play
from stplan.scene.reading.faults import scene_error
from stplan.scene.reading.load import read_text
from stplan.scene.reading.overrides import apply_overrides
from stplan.schema.yaml_tree import read_tree
from stplan.status import Status

SEED, TRAJECTORIES = "seed.npz", "trajectories.npz"
KEY = "events"
# How faults of the override begin that all events are read from.
_OF_EVENT = re.compile(rf"--set {KEY}=.*?: {KEY}\[(\d+)\]", re.DOTALL)


@dataclass(frozen=True)
class Continuation:
    """A run, and what happens to it.

    Attributes:
        scene: with all events, old and new.
        plan: as far as it was known.
        changes: the new ones.
    """

    scene: Scene
    plan: Plan
    changes: tuple[WorldChange, ...]

    def replanned(self, *, progress: Progress | None = None, stop: Stop | None = None) -> Plan:
        """The plan that goes on. Raises like `replanning.go_on`."""
        return go_on(self.scene, self.plan, self.changes, progress=progress, stop=stop)

    def rest(self) -> Certificate | None:
        """Whether the old plan's rest stays clear after the first change; None where nothing is left."""
        change, lines = self.changes[0], self.plan.trajectories or self.plan.seed
        return rest_certificate(change, space_of(change.scene), curves_of(lines))


@dataclass(frozen=True)
class Happening:
    """An event as the user gave it, and where: what messages about it begin with."""

    event: Any
    origin: str


def events_of(path: Path) -> list[Happening]:
    """The events in a YAML file: a list, or a mapping with `events`.

    Raises:
        SceneError: it holds neither, or cannot be read.
    """
    text = read_text(path)
    if not text.strip():
        raise SceneError(f"{path}:1:1: the file is empty; a list of events is expected")
    tree = read_tree(text, str(path))
    if tree.faults:
        raise scene_error(str(path), tree, {}, [])
    value, key = tree.value, ""
    if isinstance(value, Mapping):
        value, key = value.get(KEY), KEY
    if not isinstance(value, list) or not value:
        raise SceneError(f"{path}:1:1: a list of events is expected, or a mapping with events")
    found = []
    for number, event in enumerate(value):
        line, column = tree.locations.get(f"{key}[{number}]", (1, 1))
        found.append(Happening(event, f"{path}:{line}:{column}: {KEY}[{number}]"))
    return found


def set_event(at: float, settings: Sequence[str]) -> Happening:
    """The event that changes values of a scene by ``KEY=VALUE`` at a time.

    Raises:
        SceneError: a setting is of another form.
    """
    given: dict[str, Any] = {}
    for setting in settings:
        name, separator, text = setting.partition("=")
        if not separator or not text.strip():
            raise SceneError(
                f"--set {setting}: KEY=VALUE is expected, as in agents.sam.goal=[2, 3]"
            )
        tree = read_tree(text, f"--set {setting}", located=False)
        if tree.faults:
            raise SceneError([f"--set {setting}: {fault}" for _, _, fault in tree.faults])
        given[name.strip()] = tree.value
    return Happening({"at": at, "set": given}, f"--set {' '.join(settings)}")


def open_continuation(folder: Path, happenings: Sequence[Happening]) -> Continuation:
    """The run in `folder`, to which more happens.

    Raises:
        UsageError: it is damaged, of another state of its scene, or does not hold its certificate; an event
            is before what it knows already.
        SceneError: an event does not fit.
    """
    why = why_incomplete(folder)
    if why:
        raise UsageError(f"{folder} is not the whole of one run: {why}")
    recorded = recorded_scene(folder, "solve")
    report, record = read_json(folder / REPORT), read_json(folder / RUN_RECORD)
    before = load_scene(recorded.source, overrides=recorded.overrides)
    if recorded.content_hash != before.content_hash:
        raise UsageError(
            f"{recorded.source} is not as it was when {folder} was planned; plan it anew"
        )
    if is_play(before):
        raise UsageError(f"{folder} was played, and events do not go together with that")
    tree = read_tree(read_text(recorded.source), str(recorded.source))
    apply_overrides(tree, recorded.overrides)
    old = tree.value.get(KEY, [])
    overrides = [one for one in recorded.overrides if one.partition("=")[0].strip() != KEY]
    overrides.append(f"{KEY}={json.dumps([*old, *(one.event for one in happenings)])}")
    try:
        scene = load_scene(recorded.source, overrides=overrides)
    except SceneError as error:
        origins = [one.origin for one in happenings]
        raise SceneError([_placed(line, len(old), origins) for line in error.messages]) from error
    known = len(before.changes)
    kept = [replace(change, scene=scene) for change in before.changes]
    same = [replace(change, scene=scene) for change in scene.changes[:known]]
    if kept != same:
        last = before.changes[-1].at
        raise UsageError(f"{folder} knows what happens until {last:g} s; a later event is expected")
    file = read_npz(folder / TRAJECTORIES)
    lines = file.world_lines
    certificate = check(before, lines)
    if not certificate.holds:
        raise UsageError(f"{folder}: {certificate.summary}; only certified runs go on")
    planned = before
    if before.metric == "auto" and file.time_scale is not None:
        turning = before.turning_scale
        planned = replace(before, time_scale=file.time_scale, metric="chosen", turning=turning)
    seed, old_seed = read_trajectories(folder / SEED), report["seed"]
    shown = whole_scene(planned, curves_of(lines)) if planned.changes else planned
    found = SeedReport(
        old_seed["found_by"],
        old_seed["record"],
        old_seed["smallest_clearance"],
        metrics(shown, seed),
    )
    content = Report(shown, Status(report["status"]), certificate, metrics(shown, lines), found)
    past = RunRecord(record["started"], record["seconds"])
    plan = Plan(seed, lines, content, past)
    return Continuation(scene, plan, scene.changes[known:])


def _placed(message: str, known: int, origins: Sequence[str]) -> str:
    """A sentence on one of all events as one on where it was given, where it is not a `known` one."""
    found = _OF_EVENT.match(message)
    number = -1 if found is None else int(found[1]) - known
    if found is None or not 0 <= number < len(origins):
        return message
    return f"{origins[number]}: {message[found.end() :].lstrip('.: ')}"
