"""A stand-in for planning, so that what the command line adds is tested alone and at once."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import stplan.scene
import stplan.world
from stplan.cli.app import main
from stplan.errors import SceneError
from stplan.files.json_file import json_bytes
from stplan.files.trajectories import write_files
from tests.files.examples import scene_of, straight_lines


@dataclass
class Result:
    """How a command ended."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


@pytest.fixture
def run(capsys) -> Callable[..., Result]:
    """Run a command line in this process."""

    def command(*arguments: object) -> Result:
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main([str(argument) for argument in arguments])
        code = left.value.code
        out, err = capsys.readouterr()
        return Result(int(code or 0), out, err)

    return command


@dataclass
class Stage:
    """What the stand-in does: errors to raise and outcomes to give, by scene name."""

    raises: dict[str, BaseException] = field(default_factory=dict)
    outcomes: dict[str, tuple[str, int, str]] = field(default_factory=dict)
    violations: tuple[str, ...] = ()
    overrides: list[tuple[str, ...]] = field(default_factory=list)
    planned: list[str] = field(default_factory=list)
    hash: str = "0123"

    def load_scene(self, path: Path, overrides: tuple[str, ...] = ()) -> Any:
        self.overrides.append(tuple(overrides))
        if path.read_text() == "broken":
            raise SceneError([f"{path}:1:1: first fault", f"{path}:2:1: second fault"])
        scene = scene_of(["sam", "ann"], name=path.stem, source=path)
        return SimpleNamespace(
            **vars(scene) | {"content_hash": self.hash, "overrides": tuple(overrides)}
        )

    def certificate(self) -> Any:
        return SimpleNamespace(
            holds=not self.violations,
            violations=self.violations,
            summary="certificate holds" if not self.violations else "certificate IS BROKEN",
            as_dict=lambda: {"holds": not self.violations, "violations": list(self.violations)},
        )

    def plan(self, scene: Any, *, progress: Any = None, live: Any = None, stop: Any = None) -> Any:
        self.planned.append(scene.name)
        progress("outer iteration 1")
        if scene.name in self.raises:
            raise self.raises[scene.name]
        status, exit_status, advice = self.outcomes.get(scene.name, ("converged", 0, ""))
        lines = straight_lines(scene)
        rows = [
            {"agent": agent, "arrival_time": 5.0, "path_length": 4.0, "greatest_speed": 0.8}
            for agent in lines.agent_ids
        ]
        report = {
            "status": status,
            "scene": {
                "name": scene.name, "source": str(scene.source), "hash": scene.content_hash,
                "overrides": list(scene.overrides),
            },
            "certificate": {"holds": True, "pairs": {"rows": []}, "walls": {"rows": []}},
            "metrics": {"kinetic_over_straight": 1.25, "latest_arrival": 5.0, "agents": rows},
        }  # fmt: skip
        return SimpleNamespace(
            scene=scene, seed=lines, trajectories=lines, certificate=self.certificate(),
            report=report, run={"seconds": {"total": 0.5}}, status=status, advice=advice,
            exit_status=exit_status,
        )  # fmt: skip

    def write_plan(self, plan: Any, folder: Path) -> list[Path]:
        return write_files(
            folder,
            plan.scene,
            {"trajectories": plan.trajectories, "seed": plan.seed},
            {"report.json": json_bytes(plan.report), "run.json": json_bytes(plan.run)},
        )


@pytest.fixture
def stage(monkeypatch, tmp_path) -> Stage:
    """Replace reading and planning of scenes; the working directory is new."""
    acting = Stage()
    pipeline: Any = ModuleType("stplan.planner")
    pipeline.plan = pipeline.seed = acting.plan
    pipeline.write_plan = acting.write_plan
    pipeline.check = lambda scene, lines: acting.certificate()
    monkeypatch.setitem(sys.modules, "stplan.planner", pipeline)
    monkeypatch.setattr(
        stplan.world, "fitted_free_space",
        lambda scene: acting.plan(scene, progress=lambda line: None), raising=False,
    )  # fmt: skip
    monkeypatch.setattr(stplan.scene, "load_scene", acting.load_scene, raising=False)
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two", "three"):
        Path(f"{name}.yaml").write_text("stplan: 1")
    Path("bad.yaml").write_text("broken")
    return acting
