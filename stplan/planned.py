"""A plan as planning leaves it, and its files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from stplan.certify.certificate import Certificate
from stplan.files.atomic import write_set
from stplan.files.details import report_files
from stplan.files.json_file import json_bytes
from stplan.files.manifest import KEY, manifest
from stplan.files.recorded import RUN_RECORD
from stplan.files.trajectories import curve_files
from stplan.multistart import own_cost
from stplan.problem.world_lines import WorldLines
from stplan.report import Report, RivalReport, RunRecord
from stplan.scene.model import Scene
from stplan.status import Status

if TYPE_CHECKING:
    from stplan.world import FreeSpace


@dataclass(frozen=True)
class Plan:
    """A planned (or only seeded) scene.

    Attributes:
        seed: the initial curves.
        trajectories: the optimised curves, None where only a seed was asked for.
        report: what report.json holds, repeatable.
        run: what run.json holds, different every time.
    """

    seed: WorldLines
    trajectories: WorldLines | None
    report: Report
    run: RunRecord

    @property
    def scene(self) -> Scene:
        """What was planned."""
        return self.report.scene

    @property
    def certificate(self) -> Certificate:
        """Of the trajectories, or of the seed."""
        return self.report.certificate

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


def write_plan(result: Plan, folder: Path) -> list[Path]:
    """Write a plan's files into `folder` (made if needed) and return their paths."""
    return write_set(folder, plan_files(result))


def plan_files(result: Plan) -> dict[str, bytes]:
    """What `write_plan` writes, by file name: the record with the manifest of all others comes last."""
    curves = {"seed": result.seed}
    if result.trajectories is not None:
        curves["trajectories"] = result.trajectories
    contents = curve_files(result.scene, curves)
    contents |= report_files(result.report.as_dict(), len(result.scene.agents))
    return contents | {RUN_RECORD: json_bytes(result.run.as_dict() | {KEY: manifest(contents)})}


def cheapest(plans: Sequence[Plan]) -> Plan:
    """The plan that costs its agents least, with a record of all that were made."""
    costs = [own_cost(plan.scene, plan.trajectories or plan.seed) for plan in plans]
    best = plans[min(range(len(plans)), key=costs.__getitem__)]
    if len(plans) == 1:
        return best
    rivals = tuple(
        RivalReport(
            plan.report.seed.found_by,
            plan.report.seed.record["start"],
            own_cost(plan.scene, plan.seed),
            cost,
            plan.status,
        )
        for plan, cost in zip(plans, costs, strict=True)
    )
    return replace(best, report=replace(best.report, rivals=rivals))


def notes_of(space: FreeSpace | None) -> tuple[str, ...]:
    """What the user has to know about a map, by key."""
    notes = () if space is None else space.notes
    return tuple(f"{note.path}: {note.sentence}" for note in notes)
