"""A plan as planning leaves it, and its files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stplan.certify.certificate import Certificate
from stplan.files.atomic import write_set
from stplan.files.json_file import json_bytes
from stplan.files.manifest import KEY, manifest
from stplan.files.recorded import REPORT, RUN_RECORD
from stplan.files.trajectories import curve_files
from stplan.problem.world_lines import WorldLines
from stplan.report import Report, RunRecord
from stplan.scene.model import Scene
from stplan.status import Status


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
    contents = curve_files(result.scene, curves) | {REPORT: json_bytes(result.report.as_dict())}
    return contents | {RUN_RECORD: json_bytes(result.run.as_dict() | {KEY: manifest(contents)})}
